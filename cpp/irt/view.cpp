// SPDX-License-Identifier: Apache-2.0
#include "irt/view.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "irt/graph/evaluate.h"
#include "irt/math/float_state.h"
#include "irt/math/stopwatch.h"
#include "irt/scene/compile.h"
#include "irt/scene/equality.h"
#include "irt/trace/brute_force.h"
#include "irt/trace/same_point.h"
#include "irt/update/cost_model.h"

namespace irt {

namespace {

/// Largest image side; beyond it pixel indices would leave 32 bits.
constexpr int max_side = 65536;
constexpr int max_samples = 4096;
constexpr int max_depth = 10000;

/// Samples to a distinct path: room in the table is made for so few. Where there are more, paths
/// share a place that is always flagged.
constexpr std::size_t samples_a_path = 8;

ViewSettings checked(ViewSettings s) {
    if (s.width < 1 || s.height < 1 || s.width > max_side || s.height > max_side)
        throw std::invalid_argument("image size must be 1 to 65536 a side");
    if (s.frame_width == 0) s.frame_width = s.width;
    if (s.frame_height == 0) s.frame_height = s.height;
    if (s.frame_width < 1 || s.frame_height < 1 || s.frame_width > max_side ||
        s.frame_height > max_side || std::abs(s.x) > max_side || std::abs(s.y) > max_side)
        throw std::invalid_argument("the full frame must be 1 to 65536 pixels a side");
    if (s.samples < 1 || s.samples > max_samples)
        throw std::invalid_argument("samples must be 1 to 4096");
    if (s.shade.max_depth < 0 || s.shade.max_depth > max_depth)
        throw std::invalid_argument("max depth must be 0 to 10000");
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
            const auto [dx, dy] = settings.first_pixel(cell);
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

/// The cone of one sample: all of a pixel's together cover it. Where pixels are not square it has
/// the pixel's area. In perspective its width at a distance is that of a pixel in the image's
/// middle.
shade::RayCone cone_of(const Camera& camera, const ViewSettings& settings) {
    const auto& [left, right, bottom, top] = camera.window;
    const auto length = [&](const V3d& v) {
        const V3d world = transform_direction(camera.world_from_camera, v);
        return std::sqrt(world.dot(world));
    };
    const double side =
        std::sqrt(length({(right - left) / settings.frame_width, 0, 0}) *
                  length({0, (top - bottom) / settings.frame_height, 0}) / settings.samples);
    if (camera.orthographic) return {side, 0};
    return {side * camera.near, side / length({0, 0, -1})};  // rays start at the near plane
}

}  // namespace

cells::CellOffset ViewSettings::first_pixel(int cell) const {
    const auto [dx, dy] = cells::cell_offset(cell);
    const auto on_film = [](int offset, int start) {
        return ((offset - start) % cells::cell_stride + cells::cell_stride) % cells::cell_stride;
    };
    return {on_film(dx, x), on_film(dy, y)};
}

std::size_t HistorySize::all_bytes() const {
    std::size_t sum = 0;
    for (const auto& [kind, size] : bytes) sum += size;
    return sum;
}

View::View(const Camera& camera, const ViewSettings& settings, const V3d& render_origin)
    : settings_(checked(settings)),
      render_origin_(render_origin),
      sample_offsets_(sample_pattern(settings.samples)),
      film_(settings.width, settings.height, settings.aovs, settings.primvars.size(),
            settings.parts.size(), settings.samples),
      back_(film_) {
    set_camera(camera);
}

void View::check(const Camera& camera) {
    const auto& w = camera.window;
    for (const double edge : w)
        if (!std::isfinite(edge)) throw std::invalid_argument("camera: window is not finite");
    if (w[0] == w[1] || w[2] == w[3]) throw std::invalid_argument("camera: window is empty");
    if (!(camera.near >= 0 && std::isfinite(camera.near) && camera.far > camera.near))
        throw std::invalid_argument("camera: near must be 0 or more, and below far");
    (void)checked_inverse(camera.world_from_camera, "camera");
}

void View::set_camera(const Camera& camera) {
    check(camera);
    render_from_camera_ = camera.world_from_camera;
    for (int a = 0; a < 3; ++a) render_from_camera_[3][a] -= render_origin_[a];
    camera_from_render_ = checked_inverse(render_from_camera_, "camera");
    cone_ = cone_of(camera, settings_);
    eye_ = V3f(transform_point(render_from_camera_, V3d(0, 0, 0)));
    camera_ = camera;
}

trace::Ray View::primary_ray(int x, int y, int sample) const {
    const V2d& offset = sample_offsets_[static_cast<std::size_t>(sample)];
    const double u = (settings_.x + x + offset.x) / settings_.frame_width,
                 v = (settings_.y + y + offset.y) / settings_.frame_height;
    const auto& [left, right, bottom, top] = camera_.window;
    const V3d p{left + (right - left) * u, top + (bottom - top) * v, -1};
    const double near = camera_.near;
    const auto ray = [&](const V3f& start, const V3d& direction) {
        trace::Ray made = trace::make_ray(
            start, V3f(transform_direction(render_from_camera_, direction)), primary_reach());
        made.camera = true;
        return made;
    };
    if (camera_.orthographic)
        return ray(V3f(transform_point(render_from_camera_, {p.x, p.y, -near})), {0, 0, -1});
    return ray(near > 0 ? V3f(transform_point(render_from_camera_, p * near)) : eye_, p);
}

/// t_max of primary rays: their directions are 1 deep, and they start at the near plane.
float View::primary_reach() const { return static_cast<float>(camera_.far - camera_.near); }

/// A pixel from its samples: sample(s, first) gives the beauty of sample s and what it sees first,
/// then part(s, p) a part of it.
template <class Sample, class Part>
film::PixelValue View::pixel(const Scene& scene, Sample&& sample, Part&& part) const {
    film::PixelValue value;
    V3d sum{0, 0, 0};
    std::vector<V3d> sums(settings_.parts.size(), V3d(0, 0, 0));
    int covered = 0;
    film::CoverageCount objects, materials;
    for (int s = 0; s < settings_.samples; ++s) {
        shade::FirstHit first;
        sum += V3d(sample(s, first));
        for (std::size_t p = 0; p < sums.size(); ++p) sums[p] += V3d(part(s, p));
        if (!first) continue;
        if (s == 0 && film_.shows_surfaces()) show_surface(scene, first, value);
        if (first.matte) continue;
        ++covered;
        if (film_.has(film::Aov::CryptoObject)) objects.add(scene.id(first.seen.object));
        if (film_.has(film::Aov::CryptoMaterial))
            materials.add(scene.materials()[first.material].id);
    }
    const V3f mean(divided(sum, settings_.samples));
    for (int c = 0; c < 3; ++c) value.rgba[c] = mean[c];
    value.rgba[3] = static_cast<float>(static_cast<double>(covered) / settings_.samples);
    for (const V3d& each : sums) value.parts.emplace_back(divided(each, settings_.samples));
    value.objects = objects.ranks(settings_.samples);
    value.materials = materials.ranks(settings_.samples);
    return value;
}

/// The AOVs of what a sample sees.
void View::show_surface(const Scene& scene, const shade::FirstHit& first,
                        film::PixelValue& value) const {
    value.depth = static_cast<float>(-transform_point(camera_from_render_, first.position).z);
    value.normal = first.shading_normal;
    value.position = V3f(first.position + render_origin_);
    value.albedo = V3f(first.albedo);
    const trace::Hit& seen = first.seen;
    if (film_.has(film::Aov::ObjectId)) value.object_id = scene.id(seen.object);
    if (film_.has(film::Aov::InstanceId))
        if (const std::optional<std::int64_t> key = scene.key(seen.object))
            value.instance_id = static_cast<std::uint32_t>(*key);
    if (film_.has(film::Aov::ElementId))
        value.element_id = scene.surface(seen.object, seen.part).element_of(seen.primitive);
    value.seen = {seen, first.position};
    for (const std::string& name : settings_.primvars) {
        std::array<float, 4>& out = value.primvars.emplace_back();
        const graph::Site site{scene, scene.surface(seen.object, seen.part), seen};
        if (const std::optional<graph::Value> found = graph::primvar_value(site, name))
            for (std::size_t c = 0; c < 4; ++c) out[c] = static_cast<float>((*found)[c].v);
    }
}

template <class Source>
film::PixelValue View::traced_pixel(const shade::Whitted<Source>& whitted, int x, int y,
                                    const Parts& parts, shade::Scratch& scratch) const {
    scratch.tree_wanted = !parts.empty();
    const auto sample = [&](int s, shade::FirstHit& first) {
        scratch.surface_wanted = s == 0 && film_.shows_surfaces();
        const V3f beauty = whitted.sample(primary_ray(x, y, s), scratch);
        first = scratch.first;
        return beauty;
    };
    return pixel(whitted.scene(), sample, [&](int, std::size_t p) {
        return shade::part_of(parts[p], scratch.tree, 0, whitted.scene().lights());
    });
}

/// For validate.cpp, too.
template film::PixelValue View::traced_pixel(const shade::Whitted<trace::Intersector>& whitted,
                                             int x, int y, const Parts& parts,
                                             shade::Scratch& scratch) const;

film::PixelValue View::recorded_pixel(const Scene& scene, const update::CellUpdate& cell,
                                      history::SampleIndex first_sample, const Parts& parts) const {
    const auto index = [&](int s) { return first_sample + static_cast<history::SampleIndex>(s); };
    const auto sample = [&](int s, shade::FirstHit& first) {
        first = cell.first_hit(index(s), s == 0 && film_.shows_surfaces());
        return cell.radiance(index(s));
    };
    return pixel(scene, sample,
                 [&](int s, std::size_t p) { return cell.part(index(s), parts[p]); });
}

/// The colour alone, where what the samples see stands.
V3f View::recorded_color(const update::CellUpdate& cell, history::SampleIndex first) const {
    V3d sum{0, 0, 0};
    for (int s = 0; s < settings_.samples; ++s)
        sum += V3d(cell.radiance(first + static_cast<history::SampleIndex>(s)));
    return V3f(sum / settings_.samples);
}

/// Likewise the parts of the beauty.
std::vector<V3f> View::recorded_parts(const update::CellUpdate& cell, history::SampleIndex first,
                                      const Parts& parts) const {
    std::vector<V3f> values;
    for (const shade::ResolvedPart& part : parts) {
        V3d sum{0, 0, 0};
        for (int s = 0; s < settings_.samples; ++s)
            sum += V3d(cell.part(first + static_cast<history::SampleIndex>(s), part));
        values.emplace_back(divided(sum, settings_.samples));
    }
    return values;
}

/// The first changed light that a pixel responds to; else one that is gone.
film::CauseCode View::cause_of_color(const update::CellUpdate& cell, history::SampleIndex first,
                                     const update::Plan& plan) const {
    film::CauseCode gone = 0;
    for (std::uint32_t i = 0; i < plan.changed_lights.size(); ++i) {
        const film::CauseCode cause = film::make_cause(film::CauseKind::Light, i);
        const std::optional<std::size_t> light = plan.changed_lights[i];
        if (!light && gone == 0) gone = cause;
        for (int s = 0; light && s < settings_.samples; ++s)
            if (cell.responds(first + static_cast<history::SampleIndex>(s), *light)) return cause;
    }
    return gone;
}

bool View::trace_all(const Scene& scene, const trace::Intersector& intersector, int threads,
                     const cells::CellOrder& order, cells::Control& control, CellReports& reports) {
    const shade::Whitted<trace::Intersector> whitted(scene, intersector, settings_.shade, cone_);
    control.steps = block_rows(settings_);
    const Parts parts = shade::resolved(settings_.parts, scene);
    std::mutex adding;
    cells::for_each_task(threads, block_rows(settings_), [&](int row) {
        if (control.stop) return;
        shade::Scratch scratch = whitted.make_scratch();
        std::array<shade::Counts, cells::cell_count> counts{};
        for_each_pixel_in_row(settings_, order, row, [&](std::size_t cell, int x, int y) {
            scratch.counts = {};
            back_.set(x, y, traced_pixel(whitted, x, y, parts, scratch));
            if (back_.has(film::Aov::Retraced)) back_.set_retraced(x, y, scratch.counts.rays());
            counts[cell] += scratch.counts;
        });
        ++control.steps_done;
        const std::lock_guard lock(adding);
        for (std::size_t cell = 0; cell < counts.size(); ++cell)
            reports[cell].counts.rays += counts[cell];
    });
    if (control.stop) return false;
    // A full trace flags, retraces and changes every ray.
    for (CellReport& report : reports) {
        update::UpdateCounts& counts = report.counts;
        counts.flagged = counts.retraced = counts.changed = counts.rays.rays();
        counts.new_rays = counts.rays.rays() - counts.rays.shadow;
    }
    std::swap(film_, back_);
    film_.fill_causes(film::make_cause(film::CauseKind::Everything));
    has_history_ = false;
    return true;
}

bool View::trace_and_record(const Scene& scene, const trace::Intersector& intersector,
                            const Foreseen* foreseen, int threads, const cells::CellOrder& order,
                            cells::Control& control, CellReports& reports) {
    has_history_ = false;
    if (!history_) history_ = std::make_unique<History>();
    for (history::RayTrees& cell : history_->cells) {
        // Assigning would leave the arrays what they have of a block that is opened again.
        std::destroy_at(&cell);
        std::construct_at(&cell);
    }
    std::vector<trace::Box> boxes;
    for (std::uint32_t slot = 0; slot < scene.slot_count(); ++slot)
        if (const trace::Box box = intersector.box(slot); !box.empty()) boxes.push_back(box);
    const std::size_t samples = static_cast<std::size_t>(settings_.width) *
                                static_cast<std::size_t>(settings_.height) *
                                static_cast<std::size_t>(settings_.samples);
    history_->table.reset(history::VoxelGrid(history::crowded_box(std::move(boxes))),
                          samples / samples_a_path, foreseen != nullptr);
    std::optional<update::Reach> reach;
    // Parts that go by events are made of trees, which settled samples do not keep.
    const bool trees_needed = std::any_of(
        settings_.parts.begin(), settings_.parts.end(),
        [](const shade::BeautyPart& part) { return part.events != shade::Events::Any; });
    if (foreseen && !trees_needed) reach = update::make_reach(*foreseen, scene, grid());
    const Parts parts = shade::resolved(settings_.parts, scene);

    const shade::Shading shading(scene, settings_.shade, cone_);
    const update::Plan nothing;
    std::vector<bool> casts_shadows;
    for (const LightSlot& light : scene.lights())
        casts_shadows.push_back(light.record.casts_shadows);
    std::vector<update::CellUpdate> cells;
    cells.reserve(cells::cell_count);
    for (std::size_t k = 0; k < cells::cell_count; ++k)
        cells.emplace_back(shading, intersector, nothing, history_->table, history_->cells[k],
                           history_->lists[k]);
    const int groups = std::min(cells::thread_count(threads), static_cast<int>(order.size()));
    control.steps = 2 * groups * block_rows(settings_);
    std::atomic<std::size_t> blocks = 0;
    cells::for_each_group(threads, groups, order, [&](cells::CellGroup group) {
        Stopwatch watch;
        record_group(scene, group, control, cells, history_->blocks[blocks++], casts_shadows,
                     shading.emits(), reach ? &*reach : nullptr, parts);
        const double seconds = watch.lap() / static_cast<double>(group.size());
        for (const int cell : group) reports[static_cast<std::size_t>(cell)].trace = seconds;
    });
    if (control.stop) return false;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        update::UpdateCounts& counts = reports[cell].counts = cells[cell].counts();
        counts.flagged = counts.retraced = counts.changed = counts.rays.rays();
    }
    std::swap(film_, back_);
    film_.fill_causes(film::make_cause(film::CauseKind::Everything));
    has_history_ = true;
    return true;
}

/// Records the cells of `group`: the first alone, which tells how much memory the others will take,
/// for all cells hold alike (paper, section 5); then the others together.
void View::record_group(const Scene& scene, cells::CellGroup group, cells::Control& control,
                        std::vector<update::CellUpdate>& cells, history::BlockMemory& block,
                        const std::vector<bool>& casts_shadows, bool emits,
                        const update::Reach* reach, const Parts& parts) {
    const auto record = [&](std::size_t cell, int x, int y) {
        const auto first = static_cast<history::SampleIndex>(history_->cells[cell].roots.size());
        const std::uint64_t before = cells[cell].counts().retraced;
        const history::RayTrees::End end = history_->cells[cell].end();
        for (int s = 0; s < settings_.samples; ++s) cells[cell].trace_sample(primary_ray(x, y, s));
        back_.set(x, y, recorded_pixel(scene, cells[cell], first, parts));
        if (back_.has(film::Aov::Retraced))
            back_.set_retraced(x, y, cells[cell].counts().retraced - before);
        if (reach) cells[cell].settle(first, end, *reach);
    };
    const auto trees = [&](int cell) -> history::RayTrees& {
        return history_->cells[static_cast<std::size_t>(cell)];
    };
    const int pilot = group.front();
    trees(pilot) = history::RayTrees(casts_shadows, emits);
    trees(pilot).root_reach = primary_reach();
    for_each_pixel(settings_, group.first(1), control, record);
    const cells::CellGroup others = group.subspan(1);
    block.open(others.size() * history::RayTrees::bytes_like(trees(pilot)));
    for (const int cell : others) {
        trees(cell) = history::RayTrees(casts_shadows, emits, &block);
        trees(cell).root_reach = primary_reach();
        trees(cell).reserve_like(trees(pilot));
    }
    block.seal();
    for_each_pixel(settings_, others, control, record);
}

bool View::update(const Scene& scene, const trace::Intersector& intersector,
                  const update::Plan& plan, int threads, const cells::CellOrder& order,
                  bool cost_model, CellReports& reports) {
    if (!plan.regions.empty()) flag_paths(plan, threads);
    const shade::Shading shading(scene, settings_.shade, cone_);
    std::vector<update::CellUpdate> cells;
    cells.reserve(cells::cell_count);
    for (std::size_t k = 0; k < cells::cell_count; ++k) {
        if (film_.has(film::Aov::Retraced))
            history_->lists[k].retraced.resize(history_->cells[k].roots.size());
        if (film_.has(film::Aov::Cause))
            history_->lists[k].causes.resize(history_->cells[k].roots.size());
        cells.emplace_back(shading, intersector, plan, history_->table, history_->cells[k],
                           history_->lists[k]);
    }
    const Parts parts = shade::resolved(settings_.parts, scene);
    const auto write = [&](std::size_t k) {
        Stopwatch watch;
        write_pixels(scene, k, cells[k], plan, parts);
        reports[k].film = watch.lap();
        reports[k].counts = cells[k].counts();
    };
    if (film_.has(film::Aov::Retraced)) film_.clear_retraced();
    film_.fill_causes(0);
    std::atomic<int> heavy_count = 0;
    std::array<bool, cells::cell_count> heavy{};
    cells::for_each_group(threads, cells::cell_count, order, [&](cells::CellGroup group) {
        const auto k = static_cast<std::size_t>(group.front());
        Stopwatch watch;
        if (plan.lights_differ) cells[k].keep_lights();
        if (shading.emits() && !history_->cells[k].emits) history_->cells[k].start_emission();
        cells[k].detect();
        reports[k].detect = watch.lap();
        heavy[k] = cost_model &&
                   (plan.lights_moved ||
                    static_cast<double>(cells[k].counts().flagged) >
                        update::least_flagged * static_cast<double>(history_->cells[k].rays()));
        if (heavy[k]) {
            ++heavy_count;
            return;
        }
        run(cells[k], reports[k]);
        write(k);
    });
    if (heavy_count == 0) return true;

    // All cells hold alike, so that one tells what all will cost (paper, section 5).
    const auto pilot = static_cast<std::size_t>(order.front());
    const bool piloted = heavy_count == static_cast<int>(order.size());
    if (piloted) {
        run(cells[pilot], reports[pilot]);
        if (update::work(cells[pilot].counts()) >
            update::most_work * static_cast<double>(history_->cells[pilot].rays())) {
            has_history_ = false;
            return false;
        }
    }
    cells::for_each_group(threads, cells::cell_count, order, [&](cells::CellGroup group) {
        const auto k = static_cast<std::size_t>(group.front());
        if (!heavy[k]) return;
        if (!(piloted && k == pilot)) run(cells[k], reports[k]);
        write(k);
    });
    return true;
}

/// Flags the voxels' paths, on all threads.
void View::flag_paths(const update::Plan& plan, int threads) {
    constexpr std::size_t piece = 128 * history::PathTable::flag_block;
    history::PathTable& table = history_->table;
    table.clear_flags();
    const auto pieces = static_cast<int>((table.capacity() + piece - 1) / piece);
    cells::for_each_task(threads, pieces, [&](int i) {
        const std::size_t begin = static_cast<std::size_t>(i) * piece;
        table.flag(plan.regions, begin, std::min(begin + piece, table.capacity()));
    });
}

/// What follows detection in a cell, but for the film.
void View::run(update::CellUpdate& cell, CellReport& report) {
    Stopwatch watch;
    cell.test();
    report.trace = watch.lap();
    cell.shade();
    report.shade = watch.lap();
    cell.combine();
    report.combine = watch.lap();
}

/// Writes the pixels of cell `k` whose samples were walked; where lights differ, of all others the
/// colour.
void View::write_pixels(const Scene& scene, std::size_t k, const update::CellUpdate& cell,
                        const update::Plan& plan, const Parts& parts) {
    const auto [dx, dy] = settings_.first_pixel(static_cast<int>(k));
    const int columns = (settings_.width - dx + cells::cell_stride - 1) / cells::cell_stride;
    const auto samples = static_cast<history::SampleIndex>(settings_.samples);
    const auto pixel_of = [&](history::SampleIndex sample) {
        const auto pixel = static_cast<int>(sample / samples);
        return std::pair(dx + cells::cell_stride * (pixel % columns),
                         dy + cells::cell_stride * (pixel / columns));
    };
    const bool tells_causes = film_.has(film::Aov::Cause);
    if (plan.lights_differ) {
        const auto end = static_cast<history::SampleIndex>(history_->cells[k].roots.size());
        for (history::SampleIndex sample = 0; sample < end; sample += samples) {
            const auto [x, y] = pixel_of(sample);
            const bool changed = film_.set_color(x, y, recorded_color(cell, sample),
                                                 recorded_parts(cell, sample, parts));
            if (changed && tells_causes) film_.set_cause(x, y, cause_of_color(cell, sample, plan));
        }
    }
    history::SampleIndex written = history::no_node;
    for (const history::SampleIndex sample : cell.walked()) {
        const history::SampleIndex first = sample - sample % samples;
        if (std::exchange(written, first) == first) continue;  // samples of a pixel come in a row
        const auto [x, y] = pixel_of(first);
        film_.set(x, y, recorded_pixel(scene, cell, first, parts));
        if (!tells_causes) continue;
        for (history::SampleIndex s = 0; s < samples; ++s)
            if (const film::CauseCode cause = history_->lists[k].causes[first + s]) {
                film_.set_cause(x, y, cause);
                break;
            }
    }
    const std::vector<std::uint32_t>& retraced = history_->lists[k].retraced;
    for (history::SampleIndex first = 0; first < retraced.size(); first += samples) {
        const std::uint32_t rays =
            std::accumulate(&retraced[first], &retraced[first] + samples, 0u);
        const auto [x, y] = pixel_of(first);
        if (rays > 0) film_.set_retraced(x, y, rays);
    }
}

HistorySize View::history_size() const {
    HistorySize size;
    for (const history::RayTrees& cell : history_->cells) {
        size.rays += cell.rays();
        size.nodes += cell.node_count();
        size.points += cell.point_count();
        const history::Sizes sizes = cell.sizes();
        if (size.bytes.empty())
            size.bytes = sizes;
        else
            for (std::size_t i = 0; i < sizes.size(); ++i) size.bytes[i].second += sizes[i].second;
    }
    size.bytes.emplace_back("path_table", history_->table.bytes());
    return size;
}

shade::Counts View::record(const Scene& scene, const trace::Intersector& intersector,
                           shade::RayRecord& record) const {
    const shade::Recorder source(intersector, record);
    const shade::Whitted<shade::Recorder> whitted(scene, source, settings_.shade, cone_);
    shade::Scratch scratch = whitted.make_scratch();
    const cells::CellOrder order = cells::natural_order();
    cells::Control unstoppable;
    for_each_pixel(settings_, order, unstoppable,
                   [&](std::size_t, int x, int y) { traced_pixel(whitted, x, y, {}, scratch); });
    return scratch.counts;
}

film::PixelValue View::brute_force_pixel(const Scene& scene, int x, int y) const {
    const FloatState ieee;
    const trace::BruteForce source(scene);
    const shade::Whitted<trace::BruteForce> whitted(scene, source, settings_.shade, cone_);
    shade::Scratch scratch = whitted.make_scratch();
    return traced_pixel(whitted, x, y, shade::resolved(settings_.parts, scene), scratch);
}

/// In pixels of the full frame, y down.
V2d View::raster(const Camera& camera, const M44d& camera_from_render, const V3d& position) const {
    const V3d p = transform_point(camera_from_render, position);
    const double depth = camera.orthographic ? 1 : -p.z;
    const auto& [left, right, bottom, top] = camera.window;
    return {(p.x / depth - left) / (right - left) * settings_.frame_width,
            (p.y / depth - top) / (bottom - top) * settings_.frame_height};
}

std::vector<V2f> View::motion(const Scene& scene, const Scene& other,
                              const std::vector<std::uint32_t>& moved, const Camera& camera,
                              int threads) const {
    check(camera);
    M44d render_from_camera = camera.world_from_camera;
    for (int a = 0; a < 3; ++a) render_from_camera[3][a] -= render_origin_[a];
    const M44d there_from_render = checked_inverse(render_from_camera, "camera");
    const bool camera_moves = !same(camera, camera_);
    std::vector<bool> moves(scene.slot_count());
    for (const std::uint32_t slot : moved)
        if (slot < moves.size()) moves[slot] = true;
    const auto width = static_cast<std::size_t>(settings_.width);
    std::vector<V2f> motion(width * static_cast<std::size_t>(settings_.height), V2f(0, 0));
    const film::SeenPoint* const seen = film_.seen();
    cells::for_each_task(threads, settings_.height, [&](int row) {
        trace::SamePoint points(scene, other);
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(row) * width + x;
            const film::SeenPoint& here = seen[i];
            if (!here.hit || !(camera_moves || moves[here.hit.object])) continue;
            std::optional<V3d> there = here.position;
            if (moves[here.hit.object]) there = points.find(here.hit, here.position);
            if (!there) continue;
            const V2d way = raster(camera, there_from_render, *there) -
                            raster(camera_, camera_from_render_, here.position);
            if (std::isfinite(way.x) && std::isfinite(way.y)) motion[i] = V2f(V2d(way.x, -way.y));
        }
    });
    return motion;
}

}  // namespace irt
