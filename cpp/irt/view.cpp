// SPDX-License-Identifier: Apache-2.0
#include "irt/view.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "irt/math/float_state.h"
#include "irt/scene/compile.h"
#include "irt/trace/brute_force.h"

namespace irt {

namespace {

/// Largest image side; beyond it pixel indices would leave 32 bits.
constexpr int max_side = 65536;
constexpr int max_samples = 4096;
constexpr int max_depth = 64;

ViewSettings checked(const ViewSettings& s) {
    if (s.width < 1 || s.height < 1 || s.width > max_side || s.height > max_side)
        throw std::invalid_argument("image size must be 1 to 65536 a side");
    if (s.samples < 1 || s.samples > max_samples)
        throw std::invalid_argument("samples must be 1 to 4096");
    if (s.shade.max_depth < 0 || s.shade.max_depth > max_depth)
        throw std::invalid_argument("max depth must be 0 to 64");
    if (!(s.shade.throughput_cutoff > 0 && s.shade.throughput_cutoff <= 1))
        throw std::invalid_argument("throughput cut-off must be above 0 and at most 1");
    if (!(s.shade.mirror_roughness >= 0 && s.shade.mirror_roughness <= 1))
        throw std::invalid_argument("mirror roughness must be 0 to 1");
    return s;
}

/// The fixed pattern of sub-samples: a rank-1 lattice by the golden ratio (the Fibonacci lattice),
/// the same in every pixel; one sample lies in the centre.
std::vector<V2d> sample_pattern(int samples) {
    constexpr double golden = 0.6180339887498949;
    std::vector<V2d> offsets;
    for (int i = 0; i < samples; ++i) {
        const double y = 0.5 + golden * i;
        offsets.emplace_back((i + 0.5) / samples, y - std::floor(y));
    }
    return offsets;
}

/// Calls `body(cell, x, y)` for the pixels of the cells in `group` in one row of blocks of 8 by 8,
/// block by block, so that neighbours follow each other.
template <class Body>
void for_each_pixel_in_row(const ViewSettings& settings, cells::CellGroup group, int row,
                           Body&& body) {
    for (int block_x = 0; block_x < settings.width; block_x += cells::cell_stride)
        for (const int cell : group) {
            const auto [dx, dy] = cells::cell_offset(cell);
            const int x = block_x + dx, y = row * cells::cell_stride + dy;
            if (x < settings.width && y < settings.height)
                body(static_cast<std::size_t>(cell), x, y);
        }
}

int block_rows(const ViewSettings& settings) {
    return (settings.height + cells::cell_stride - 1) / cells::cell_stride;
}

/// Calls `body(cell, x, y)` for every pixel of the cells in `group`, row by row of blocks. Counts a
/// step a row; false if stopped.
template <class Body>
bool for_each_pixel(const ViewSettings& settings, cells::CellGroup group, cells::Control& control,
                    Body&& body) {
    for (int row = 0; row < block_rows(settings); ++row) {
        if (control.stop) return false;
        for_each_pixel_in_row(settings, group, row, body);
        ++control.steps_done;
    }
    return true;
}

}  // namespace

View::View(const Camera& camera, const ViewSettings& settings, const V3d& render_origin)
    : settings_(checked(settings)),
      render_origin_(render_origin),
      sample_offsets_(sample_pattern(settings.samples)),
      film_(settings.width, settings.height, settings.aovs),
      back_(film_) {
    set_camera(camera);
}

void View::check(const Camera& camera) {
    const auto& w = camera.window;
    for (const double edge : w)
        if (!std::isfinite(edge)) throw std::invalid_argument("camera: window is not finite");
    if (w[0] == w[1] || w[2] == w[3]) throw std::invalid_argument("camera: window is empty");
    (void)checked_inverse(camera.world_from_camera, "camera");
}

void View::set_camera(const Camera& camera) {
    check(camera);
    render_from_camera_ = camera.world_from_camera;
    for (int a = 0; a < 3; ++a) render_from_camera_[3][a] -= render_origin_[a];
    camera_from_render_ = checked_inverse(render_from_camera_, "camera");
    camera_ = camera;
}

trace::Ray View::primary_ray(int x, int y, int sample) const {
    const V2d& offset = sample_offsets_[static_cast<std::size_t>(sample)];
    const double u = (x + offset.x) / settings_.width, v = (y + offset.y) / settings_.height;
    const auto& [left, right, bottom, top] = camera_.window;
    const V3d p{left + (right - left) * u, top + (bottom - top) * v, -1};
    if (camera_.orthographic)
        return trace::make_ray(V3f(transform_point(render_from_camera_, {p.x, p.y, 0})),
                               V3f(transform_direction(render_from_camera_, {0, 0, -1})));
    return trace::make_ray(eye_, V3f(transform_direction(render_from_camera_, p)));
}

/// A pixel from its samples: sample(s, first) gives the beauty of sample s and what it sees first.
template <class Sample>
film::PixelValue View::pixel(Sample&& sample) const {
    film::PixelValue value;
    V3d sum{0, 0, 0};
    int covered = 0;
    for (int s = 0; s < settings_.samples; ++s) {
        shade::FirstHit first;
        sum += V3d(sample(s, first));
        covered += first.hit;
        if (s > 0 || !first.hit || !film_.has_aovs()) continue;
        value.depth = static_cast<float>(-transform_point(camera_from_render_, first.position).z);
        value.normal = first.shading_normal;
        value.position = V3f(first.position + render_origin_);
        value.albedo = first.albedo;
        value.object_id = first.id;
    }
    const V3f mean(divided(sum, settings_.samples));
    for (int c = 0; c < 3; ++c) value.rgba[c] = mean[c];
    value.rgba[3] = static_cast<float>(static_cast<double>(covered) / settings_.samples);
    return value;
}

template <class Source>
film::PixelValue View::traced_pixel(const shade::Whitted<Source>& whitted, int x, int y,
                                    shade::Scratch& scratch) const {
    return pixel([&](int s, shade::FirstHit& first) {
        scratch.surface_wanted = s == 0 && film_.has_aovs();
        const V3f beauty = whitted.sample(primary_ray(x, y, s), scratch);
        first = scratch.first;
        return beauty;
    });
}

film::PixelValue View::recorded_pixel(const update::CellUpdate& cell,
                                      history::NodeIndex first_root) const {
    return pixel([&](int s, shade::FirstHit& first) {
        const history::NodeIndex root = first_root + static_cast<history::NodeIndex>(s);
        first = cell.first_hit(root);
        return cell.radiance(root);
    });
}

/// The colour alone, where what the samples see stands.
V3f View::recorded_color(const update::CellUpdate& cell, history::NodeIndex first_root) const {
    V3d sum{0, 0, 0};
    for (int s = 0; s < settings_.samples; ++s)
        sum += V3d(cell.radiance(first_root + static_cast<history::NodeIndex>(s)));
    return V3f(sum / settings_.samples);
}

bool View::trace_all(const Scene& scene, const trace::Intersector& intersector, int threads,
                     const cells::CellOrder& order, cells::Control& control, CellReports& reports) {
    const shade::Whitted<trace::Intersector> whitted(scene, intersector, settings_.shade);
    control.steps = block_rows(settings_);
    std::mutex adding;
    cells::for_each_task(threads, block_rows(settings_), [&](int row) {
        if (control.stop) return;
        shade::Scratch scratch = whitted.make_scratch();
        std::array<shade::Counts, cells::cell_count> counts{};
        for_each_pixel_in_row(settings_, order, row, [&](std::size_t cell, int x, int y) {
            scratch.counts = {};
            back_.set(x, y, traced_pixel(whitted, x, y, scratch));
            counts[cell] += scratch.counts;
        });
        ++control.steps_done;
        const std::lock_guard lock(adding);
        for (std::size_t cell = 0; cell < counts.size(); ++cell) reports[cell].rays += counts[cell];
    });
    if (control.stop) return false;
    // A full trace flags, retraces and changes every ray.
    for (update::UpdateCounts& counts : reports)
        counts.flagged = counts.retraced = counts.changed = counts.new_rays = counts.rays.rays();
    std::swap(film_, back_);
    return true;
}

bool View::trace_and_record(const Scene& scene, const trace::Intersector& intersector, int threads,
                            const cells::CellOrder& order, cells::Control& control,
                            CellReports& reports) {
    history_ = std::make_unique<History>();
    std::vector<trace::Box> boxes;
    for (std::uint32_t slot = 0; slot < scene.objects().size(); ++slot)
        if (const trace::Box box = intersector.box(slot); !box.empty()) boxes.push_back(box);
    history_->table.reset(history::VoxelGrid(history::crowded_box(std::move(boxes))));

    const shade::Shading shading(scene, settings_.shade);
    const update::Plan nothing;
    std::vector<update::CellUpdate> cells;
    history_->cells.fill(history::RayTrees(scene.lights().size()));
    for (history::RayTrees& trees : history_->cells)
        cells.emplace_back(shading, intersector, nothing, history_->table, trees);
    const int groups = std::min(cells::thread_count(threads), cells::cell_count);
    control.steps = groups * 2 * block_rows(settings_);
    cells::for_each_group(threads, groups, order, [&](cells::CellGroup group) {
        // The roots first, so that they are the first nodes; then what they see and spawn.
        for_each_pixel(settings_, group, control, [&](std::size_t cell, int x, int y) {
            for (int s = 0; s < settings_.samples; ++s) cells[cell].add_root(primary_ray(x, y, s));
        });
        std::array<history::NodeIndex, cells::cell_count> root{};
        for_each_pixel(settings_, group, control, [&](std::size_t cell, int x, int y) {
            const history::NodeIndex first = root[cell];
            for (int s = 0; s < settings_.samples; ++s) cells[cell].trace_root(root[cell]++);
            back_.set(x, y, recorded_pixel(cells[cell], first));
        });
    });
    if (control.stop) {
        history_.reset();
        return false;
    }
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        update::UpdateCounts& counts = reports[cell] = cells[cell].counts();
        counts.flagged = counts.retraced = counts.changed = counts.new_rays;
    }
    std::swap(film_, back_);
    return true;
}

void View::update(const Scene& scene, const trace::Intersector& intersector,
                  const update::Plan& plan, int threads, const cells::CellOrder& order,
                  CellReports& reports) {
    history_->table.flag(plan.regions);
    const shade::Shading shading(scene, settings_.shade);
    cells::for_each_group(threads, cells::cell_count, order, [&](cells::CellGroup group) {
        const auto k = static_cast<std::size_t>(group.front());
        update::CellUpdate cell(shading, intersector, plan, history_->table, history_->cells[k]);
        if (plan.lights_differ) cell.keep_lights();
        cell.detect();
        history::NodeIndex root = 0;
        cells::Control unstoppable;
        for_each_pixel(settings_, group, unstoppable, [&](std::size_t, int x, int y) {
            const history::NodeIndex first = root;
            bool walked = false;
            for (int s = 0; s < settings_.samples; ++s) walked |= cell.walk_root(root++);
            if (walked)
                film_.set(x, y, recorded_pixel(cell, first));
            else if (plan.lights_differ)
                film_.set_color(x, y, recorded_color(cell, first));
        });
        reports[k] = cell.counts();
    });
}

std::uint64_t View::history_rays() const {
    std::uint64_t rays = 0;
    for (const history::RayTrees& cell : history_->cells) rays += cell.rays();
    return rays;
}

std::size_t View::history_bytes() const {
    std::size_t bytes = 0;
    for (const history::RayTrees& cell : history_->cells) bytes += cell.bytes();
    return bytes;
}

shade::Counts View::record(const Scene& scene, const trace::Intersector& intersector,
                           shade::RayRecord& record) const {
    const shade::Recorder source(intersector, record);
    const shade::Whitted<shade::Recorder> whitted(scene, source, settings_.shade);
    shade::Scratch scratch = whitted.make_scratch();
    const cells::CellOrder order = cells::natural_order();
    cells::Control unstoppable;
    for_each_pixel(settings_, order, unstoppable,
                   [&](std::size_t, int x, int y) { traced_pixel(whitted, x, y, scratch); });
    return scratch.counts;
}

film::PixelValue View::brute_force_pixel(const Scene& scene, int x, int y) const {
    const FloatState ieee;
    const trace::BruteForce source(scene);
    const shade::Whitted<trace::BruteForce> whitted(scene, source, settings_.shade);
    shade::Scratch scratch = whitted.make_scratch();
    return traced_pixel(whitted, x, y, scratch);
}

}  // namespace irt
