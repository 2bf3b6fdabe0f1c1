// SPDX-License-Identifier: Apache-2.0
// A view of a scene: camera, film and cells. One scene may carry several.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "irt/cells/cells.h"
#include "irt/film/film.h"
#include "irt/history/block_memory.h"
#include "irt/scene/scene.h"
#include "irt/shade/light_path.h"
#include "irt/shade/recorder.h"
#include "irt/shade/settings.h"
#include "irt/shade/whitted.h"
#include "irt/trace/intersector.h"
#include "irt/update/cell_update.h"

namespace irt {

/// The film is the data window: `width` by `height` pixels whose upper left one is pixel (`x`, `y`)
/// of the full frame, which `frame_width` and `frame_height` tell the size of (0: that of the
/// film). It may reach beyond the frame. Cells and pixels are counted on the full frame (DESIGN 3,
/// rule 10), so that a pixel has the same value in whatever window it is seen.
struct ViewSettings {
    int width = 960, height = 540;
    int x = 0, y = 0;
    int frame_width = 0, frame_height = 0;
    int samples = 1;  ///< a pixel
    shade::Settings shade;
    std::vector<film::Aov> aovs;
    std::vector<std::string> primvars;  ///< AOVs of these, without "primvars:"
    std::vector<shade::BeautyPart> parts;

    /// The film's first pixel of a cell.
    [[nodiscard]] cells::CellOffset first_pixel(int cell) const;
};

/// What a cell did in an update, and processor seconds by phase. Of an initial step the seconds are
/// those of its task, which is one cell's only where every cell is a task of its own.
struct CellReport {
    update::UpdateCounts counts;
    double detect = 0, trace = 0, shade = 0, combine = 0, film = 0;
};
using CellReports = std::array<CellReport, cells::cell_count>;

/// Counts of a history, and bytes by kind of structure.
struct HistorySize {
    std::uint64_t rays = 0, nodes = 0, points = 0;
    history::Sizes bytes;

    [[nodiscard]] std::size_t all_bytes() const;
};

class View {
  public:
    /// Throws std::invalid_argument on sizes, samples or settings out of range.
    View(const Camera& camera, const ViewSettings& settings, const V3d& render_origin);

    [[nodiscard]] const Camera& camera() const { return camera_; }
    [[nodiscard]] const ViewSettings& settings() const { return settings_; }
    /// Throws std::invalid_argument on a camera that nothing can be seen through.
    static void check(const Camera& camera);
    void set_camera(const Camera& camera);

    /// Traces every pixel and replaces the film, unless stopped: then the last whole film stays and
    /// the result is false.
    bool trace_all(const Scene& scene, const trace::Intersector& intersector, int threads,
                   const cells::CellOrder& order, cells::Control& control, CellReports& reports);

    /// As trace_all, and keeps the history of every ray (the paper's initial step).
    /// `foreseen` may be null: then anything may change.
    bool trace_and_record(const Scene& scene, const trace::Intersector& intersector,
                          const Foreseen* foreseen, int threads, const cells::CellOrder& order,
                          cells::Control& control, CellReports& reports);

    /// Brings film and history up to `plan` (the paper's incremental update step). Needs a history;
    /// runs to its end. False where `cost_model` finds a full trace cheaper: then the film stands,
    /// and the history is lost.
    bool update(const Scene& scene, const trace::Intersector& intersector, const update::Plan& plan,
                int threads, const cells::CellOrder& order, bool cost_model, CellReports& reports);

    /// Says so in the film, where that was asked for.
    void nothing_retraced() {
        film_.clear_retraced();
        film_.fill_causes(0);
    }

    /// By pixel how far, in pixels to the right and upwards, its visible point is elsewhere in
    /// another state of the scene: `other`, seen through `camera`, in which the slots `moved`
    /// differ. 0 where there is no point, or none that corresponds. Needs Aov::Seen.
    [[nodiscard]] std::vector<V2f> motion(const Scene& scene, const Scene& other,
                                          const std::vector<std::uint32_t>& moved,
                                          const Camera& camera, int threads) const;

    [[nodiscard]] bool has_history() const { return has_history_; }
    void release_history() {
        has_history_ = false;
        history_.reset();
    }

    /// For checkpoints (checkpoint/arrays.h): film and history. The camera, the settings and what
    /// follows from them are the maker's.
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self);
    /// What the history holds, cells and table together.
    [[nodiscard]] HistorySize history_size() const;
    /// Distinct paths in the history's table.
    [[nodiscard]] std::size_t history_paths() const { return history_->table.entries(); }
    /// The grid of the history's paths.
    [[nodiscard]] const history::VoxelGrid& grid() const { return history_->table.grid(); }

    /// Checks every invariant of the history, and the film against it. For tests. Throws
    /// std::logic_error naming the first that is broken.
    void validate(const Scene& scene, const trace::Intersector& intersector) const;

    /// Traces every pixel on the calling thread and appends every ray to `record`;
    /// the film stands.
    shade::Counts record(const Scene& scene, const trace::Intersector& intersector,
                         shade::RayRecord& record) const;

    [[nodiscard]] const film::Film& film() const { return film_; }

    /// One pixel through the brute-force twin.
    [[nodiscard]] film::PixelValue brute_force_pixel(const Scene& scene, int x, int y) const;

    /// The primary ray of sample `sample` of pixel (x, y).
    [[nodiscard]] trace::Ray primary_ray(int x, int y, int sample) const;

  private:
    using Parts = std::vector<shade::ResolvedPart>;
    struct History {
        history::PathTable table;
        std::array<history::BlockMemory, cells::cell_count> blocks;  ///< by task
        std::array<history::RayTrees, cells::cell_count> cells;
        std::array<update::CellLists, cells::cell_count> lists;
    };
    void record_group(const Scene& scene, cells::CellGroup group, cells::Control& control,
                      std::vector<update::CellUpdate>& cells, history::BlockMemory& block,
                      const std::vector<bool>& casts_shadows, bool emits,
                      const update::Reach* reach, const Parts& parts);

    template <class Sample, class Part>
    film::PixelValue pixel(const Scene& scene, Sample&& sample, Part&& part) const;
    void show_surface(const Scene& scene, const shade::FirstHit& first,
                      film::PixelValue& value) const;
    template <class Source>
    film::PixelValue traced_pixel(const shade::Whitted<Source>& whitted, int x, int y,
                                  const Parts& parts, shade::Scratch& scratch) const;
    film::PixelValue recorded_pixel(const Scene& scene, const update::CellUpdate& cell,
                                    history::SampleIndex first, const Parts& parts) const;
    V3f recorded_color(const update::CellUpdate& cell, history::SampleIndex first) const;
    std::vector<V3f> recorded_parts(const update::CellUpdate& cell, history::SampleIndex first,
                                    const Parts& parts) const;
    [[nodiscard]] film::CauseCode cause_of_color(const update::CellUpdate& cell,
                                                 history::SampleIndex first,
                                                 const update::Plan& plan) const;
    [[nodiscard]] V2d raster(const Camera& camera, const M44d& camera_from_render,
                             const V3d& position) const;
    void flag_paths(const update::Plan& plan, int threads);
    static void run(update::CellUpdate& cell, CellReport& report);
    void write_pixels(const Scene& scene, std::size_t k, const update::CellUpdate& cell,
                      const update::Plan& plan, const Parts& parts);

    [[nodiscard]] float primary_reach() const;

    Camera camera_;
    ViewSettings settings_;
    V3d render_origin_;
    M44d render_from_camera_, camera_from_render_;
    V3f eye_{0, 0, 0};                 ///< render space
    shade::RayCone cone_;              ///< of a sample
    std::vector<V2d> sample_offsets_;  ///< within the pixel, [0, 1)
    film::Film film_, back_;
    std::unique_ptr<History> history_;
    bool has_history_ = false;  ///< history_ is that of the film
};

}  // namespace irt
