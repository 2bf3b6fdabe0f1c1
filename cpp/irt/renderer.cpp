// SPDX-License-Identifier: Apache-2.0
#include "irt/renderer.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

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
    : options_(options), scene_(options.render_origin), intersector_(options.isa, options.threads) {
    views_.emplace_back(new ViewState{View(camera, settings, options.render_origin)});
}

void Renderer::add_view(const Camera& camera, const ViewSettings& settings) {
    const FloatState ieee;
    const Exclusive exclusive(updating_);
    views_.emplace_back(new ViewState{View(camera, settings, options_.render_origin)});
}

void Renderer::remove_view(std::size_t view) {
    const Exclusive exclusive(updating_);
    views_.at(view);
    views_.erase(views_.begin() + static_cast<std::ptrdiff_t>(view));
}

void Renderer::release_history(std::size_t view) {
    const Exclusive exclusive(updating_);
    views_.at(view)->view.release_history();
}

std::vector<UpdateReport> Renderer::update(const ChangeSet& changes,
                                           const std::vector<ViewUpdate>& views,
                                           cells::Control& control) {
    const FloatState ieee;
    const Exclusive exclusive(updating_);
    if (views.size() != views_.size())
        throw std::invalid_argument("an update tells something of each view");
    std::vector<UpdateReport> reports(views.size());
    Stopwatch watch;
    std::vector<bool> camera_changed, was_current;
    for (std::size_t v = 0; v < views.size(); ++v) {
        const std::optional<Camera>& camera = views[v].camera;
        camera_changed.push_back(camera && !same(*camera, views_[v]->view.camera()));
        was_current.push_back(views_[v]->film_is_current);
        if (camera_changed[v]) View::check(*camera);
    }
    SceneUpdate scene;
    scene.first = !committed_;
    scene.old_lights = scene_.lights();
    scene.applied = scene_.apply(changes);
    if (!scene.applied.empty()) changed_lights_ = scene.applied.lights;
    reports[0].apply_seconds = watch.lap();

    // Whatever throws from here on leaves films to be made anew, and the trees to catch up.
    const bool changed = !scene.applied.empty();
    for (std::size_t v = 0; v < views.size(); ++v) {
        ViewState& state = *views_[v];
        if (camera_changed[v]) state.view.set_camera(*views[v].camera);
        if (camera_changed[v] || changed) state.film_is_current = false;
        if (camera_changed[v] || changed) state.behind = false;
    }
    scene.old_boxes = update::former_boxes(intersector_, scene.applied);
    uncommitted_.insert(uncommitted_.end(), scene.applied.geometry.begin(),
                        scene.applied.geometry.end());
    if (!uncommitted_.empty() || scene.first) intersector_.commit(scene_, uncommitted_);
    uncommitted_.clear();
    intersector_.follow(scene.applied);
    committed_ = true;
    reports[0].bvh_seconds = watch.lap();

    scene.foreseen = !options_.foreseen || scene.first ||
                     options_.foreseen->covers(scene_, scene.applied, scene.old_lights);
    if (!scene.foreseen) options_.foreseen = nullptr;
    for (std::size_t v = 0; v < views.size(); ++v)
        if (changed) views_[v]->behind = was_current[v] && !camera_changed[v];
    control.views = static_cast<int>(views.size());
    for (std::size_t v = 0; v < views.size() && !control.stop; ++v) {
        if (!views[v].wanted) continue;
        control.begin_view(static_cast<int>(v));
        const bool catches_up = std::exchange(views_[v]->behind, false) && !changed;
        update_view(*views_[v], catches_up ? missed_ : scene, was_current[v] || catches_up,
                    camera_changed[v], views[v].keep_history, control, reports[v]);
    }
    bool missed = false;
    for (std::size_t v = 0; v < views.size(); ++v) {
        reports[v].stopped = views[v].wanted && !views_[v]->film_is_current;
        missed = missed || views_[v]->behind;
    }
    if (!missed)
        missed_ = {};
    else if (changed)
        missed_ = std::move(scene);
    return reports;
}

void Renderer::update_view(ViewState& state, const SceneUpdate& scene, bool was_current,
                           bool camera_changed, bool keep_history, cells::Control& control,
                           UpdateReport& report) {
    View& view = state.view;
    report.all_rays = state.film_rays;
    if (state.film_is_current) return view.nothing_retraced();
    Stopwatch watch;
    report.traced = true;
    const bool first = !std::exchange(state.begun, true);
    if (was_current && !camera_changed && scene.foreseen && view.has_history()) {
        const update::Plan plan = update::make_plan(
            scene_, intersector_, view.grid(), scene.applied, scene.old_boxes, scene.old_lights);
        report.plan_seconds = watch.lap();
        state.film_is_current = view.update(scene_, intersector_, plan, options_.threads,
                                            options_.cell_order, options_.cost_model, report.cells);
        if (state.film_is_current) {
            state.backoff.update_paid();
        } else {
            state.backoff.update_failed();
            report.restart = "cost: a full trace is cheaper than this update";
            report.cells = {};
        }
    } else if (!first) {
        report.restart = camera_changed      ? "camera changed"
                         : !was_current      ? "the last update did not end"
                         : !scene.foreseen   ? "something changed that was not foreseen"
                         : !options_.history ? "no history is kept"
                                             : "cost: no history was recorded";
    }
    if (!state.film_is_current) {
        const bool record = options_.history && keep_history && state.backoff.record();
        state.film_is_current =
            record ? view.trace_and_record(scene_, intersector_, options_.foreseen.get(),
                                           options_.threads, options_.cell_order, control,
                                           report.cells)
                   : view.trace_all(scene_, intersector_, options_.threads, options_.cell_order,
                                    control, report.cells);
    }
    report.trace_seconds = watch.lap();
    if (view.has_history()) {
        report.history = view.history_size();
        state.film_rays = report.history.rays;
    } else {
        state.film_rays = 0;
        for (const CellReport& cell : report.cells) state.film_rays += cell.counts.rays.rays();
    }
    report.all_rays = state.film_rays;
}

std::vector<V2f> Renderer::motion(const ChangeSet& changes, const std::optional<Camera>& camera,
                                  std::size_t view) const {
    const FloatState ieee;
    const View& seen = views_.at(view)->view;
    if (!seen.film().has(film::Aov::Seen))
        throw std::invalid_argument("motion needs the AOV irt.seen");
    Scene other(scene_);
    const AppliedChanges applied = other.apply(changes);
    return seen.motion(scene_, other, applied.geometry, camera.value_or(seen.camera()),
                       options_.threads);
}

std::string Renderer::cause_name(film::CauseCode cause) const {
    const std::uint32_t index = film::cause_index(cause);
    switch (film::cause_kind(cause)) {
        case film::CauseKind::Object:
            return scene_.live(index) ? scene_.name(index) : scene_.object(index).path;
        case film::CauseKind::Material:
            return scene_.materials()[index].name;
        case film::CauseKind::Light:
            return index < changed_lights_.size() ? changed_lights_[index] : "";
        default:
            return "";
    }
}

std::map<std::uint32_t, std::string> Renderer::names(film::Aov kind,
                                                     std::set<std::uint32_t> ids) const {
    std::map<std::uint32_t, std::string> found;
    const auto offer = [&](std::uint32_t hash, auto&& name) {
        const std::uint32_t id = film::cryptomatte_id(hash);
        if (!ids.contains(id)) return;
        auto [entry, fresh] = found.emplace(id, name());
        if (!fresh) entry->second = std::min(entry->second, name());
    };
    if (kind == film::Aov::CryptoMaterial) {
        for (const MaterialSlot& material : scene_.materials())
            if (material.live) offer(material.id, [&] { return material.name; });
        return found;
    }
    for (std::uint32_t slot = 0; slot < scene_.slot_count(); ++slot)
        if (scene_.live(slot)) offer(scene_.id(slot), [&] { return scene_.name(slot); });
    return found;
}

film::PixelValue Renderer::brute_force_pixel(int x, int y, std::size_t view) const {
    return views_.at(view)->view.brute_force_pixel(scene_, x, y);
}

}  // namespace irt
