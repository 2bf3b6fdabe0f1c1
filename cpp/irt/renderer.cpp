// SPDX-License-Identifier: Apache-2.0
#include "irt/renderer.h"

#include <stdexcept>

#include "irt/math/stopwatch.h"
#include "irt/scene/equality.h"
#include "irt/update/make_plan.h"

namespace irt {

namespace {

/// Holds `flag` up; throws if it is up already.
class Exclusive {
  public:
    explicit Exclusive(std::atomic<bool>& flag) : flag_(flag) {
        if (flag_.exchange(true)) throw std::logic_error("an update is running already");
    }
    ~Exclusive() { flag_ = false; }
    Exclusive(const Exclusive&) = delete;
    Exclusive& operator=(const Exclusive&) = delete;

  private:
    std::atomic<bool>& flag_;
};

}  // namespace

Renderer::Renderer(const Camera& camera, const ViewSettings& settings,
                   const RendererOptions& options)
    : Renderer(FloatState(), camera, settings, options) {}

Renderer::Renderer(const FloatState& /*while_constructing*/, const Camera& camera,
                   const ViewSettings& settings, const RendererOptions& options)
    : options_(options),
      scene_(options.render_origin),
      intersector_(options.isa, options.threads),
      view_(camera, settings, options.render_origin) {}

UpdateReport Renderer::update(const ChangeSet& changes, const std::optional<Camera>& camera,
                              bool keep_history, cells::Control& control) {
    const FloatState ieee;
    const Exclusive exclusive(updating_);
    UpdateReport report;
    Stopwatch watch;
    const bool camera_changed = camera && !same(*camera, view_.camera());
    const bool first = scene_.version() == 0 && !film_is_current_;
    const std::vector<LightSlot> old_lights = scene_.lights();
    if (camera_changed) View::check(*camera);
    const AppliedChanges applied = scene_.apply(changes);
    if (camera_changed) view_.set_camera(*camera);
    report.apply_seconds = watch.lap();
    report.all_rays = film_rays_;
    const bool was_current = film_is_current_;
    if (was_current && applied.empty() && !camera_changed) {
        view_.nothing_retraced();
        return report;
    }

    // Whatever throws from here on leaves the film to be made anew, and the trees to catch up.
    film_is_current_ = false;
    const std::vector<trace::Box> old_boxes = update::former_boxes(intersector_, applied);
    uncommitted_.insert(uncommitted_.end(), applied.geometry.begin(), applied.geometry.end());
    if (!uncommitted_.empty() || first) intersector_.commit(scene_, uncommitted_);
    uncommitted_.clear();
    intersector_.release_meshes(applied.rebound);
    report.bvh_seconds = watch.lap();

    report.traced = true;
    const bool foreseen =
        !options_.foreseen || first || options_.foreseen->covers(scene_, applied, old_lights);
    if (!foreseen) options_.foreseen = nullptr;
    if (was_current && !camera_changed && foreseen && view_.has_history()) {
        const update::Plan plan =
            update::make_plan(scene_, intersector_, view_.grid(), applied, old_boxes, old_lights);
        report.plan_seconds = watch.lap();
        film_is_current_ = view_.update(scene_, intersector_, plan, options_.threads,
                                        options_.cell_order, options_.cost_model, report.cells);
        if (film_is_current_) {
            backoff_.update_paid();
        } else {
            backoff_.update_failed();
            report.restart = "cost: a full trace is cheaper than this update";
            report.cells = {};
        }
    } else if (!first) {
        report.restart = camera_changed      ? "camera changed"
                         : !was_current      ? "the last update did not end"
                         : !foreseen         ? "something changed that was not foreseen"
                         : !options_.history ? "no history is kept"
                                             : "cost: no history was recorded";
    }
    if (!film_is_current_) {
        const bool record = options_.history && keep_history && backoff_.record();
        film_is_current_ = record
                               ? view_.trace_and_record(scene_, intersector_,
                                                        options_.foreseen.get(), options_.threads,
                                                        options_.cell_order, control, report.cells)
                               : view_.trace_all(scene_, intersector_, options_.threads,
                                                 options_.cell_order, control, report.cells);
        report.stopped = !film_is_current_;
    }
    report.trace_seconds = watch.lap();
    if (view_.has_history()) {
        report.history = view_.history_size();
        film_rays_ = report.history.rays;
    } else {
        film_rays_ = 0;
        for (const CellReport& cell : report.cells) film_rays_ += cell.counts.rays.rays();
    }
    report.all_rays = film_rays_;
    return report;
}

film::PixelValue Renderer::brute_force_pixel(int x, int y) const {
    return view_.brute_force_pixel(scene_, x, y);
}

}  // namespace irt
