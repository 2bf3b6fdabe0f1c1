// SPDX-License-Identifier: Apache-2.0
// The facade: one scene, its trees, and the views of it.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "irt/checkpoint/arrays.h"
#include "irt/math/float_state.h"
#include "irt/scene/scene.h"
#include "irt/trace/intersector.h"
#include "irt/update/cost_model.h"
#include "irt/view.h"

namespace irt {

struct RendererOptions {
    V3d render_origin{0, 0, 0};  ///< world
    std::string isa = "avx2";
    int threads = 0;      ///< 0: all of the machine
    bool history = true;  ///< false: every update that changes anything is a full trace
    /// Full traces take the place of updates that would cost more; false: never.
    bool cost_model = true;
    cells::CellOrder cell_order = cells::natural_order();
    /// What can ever change; null: anything. An update that changes something else starts again.
    std::shared_ptr<const Foreseen> foreseen;
};

/// What an update did. `restart` says why the update is an initial step, and is empty where it is
/// none, or the first.
struct UpdateReport {
    std::string restart;
    bool traced = false;  ///< false: nothing had changed, the film stands
    bool stopped = false;
    std::uint64_t all_rays = 0;  ///< that make up the film
    HistorySize history;         ///< empty where none is kept
    double apply_seconds = 0, bvh_seconds = 0, plan_seconds = 0, trace_seconds = 0;
    CellReports cells;
};

/// What an update is told of one view.
struct ViewUpdate {
    std::optional<Camera> camera;  ///< empty: as it was
    /// False: a full trace records nothing, for the caller knows that the next update could not use
    /// it.
    bool keep_history = true;
    /// False: the view is left as it is. The next update catches up with what this one changed, and
    /// traces the view anew if it changes more.
    bool wanted = true;
};

class Renderer {
  public:
    Renderer(const Camera& camera, const ViewSettings& settings, const RendererOptions& options);

    /// Adds another view of the same scene, with a history of its own. Its films are those of a
    /// renderer that has it alone, and the same options.
    void add_view(const Camera& camera, const ViewSettings& settings);
    /// Those after it take the numbers before theirs. Throws std::out_of_range.
    void remove_view(std::size_t view);
    [[nodiscard]] std::size_t view_count() const { return views_.size(); }
    /// Frees what is kept of a view's rays: its next update is a full trace.
    void release_history(std::size_t view);
    /// Whether a view's film shows the scene as the last update left it.
    [[nodiscard]] bool is_current(std::size_t view) const {
        return views_.at(view)->film_is_current;
    }

    /// Applies `changes` and brings every view's film up to them and to its camera; `views` has one
    /// entry a view, and so has the result (time spent on the scene is the first one's). Where
    /// nothing changed nothing is traced. Throws std::invalid_argument on records that cannot be
    /// rendered; nothing is then applied. A stopped update leaves the last whole films; the next
    /// one makes up for it. Throws std::logic_error if called while an update runs.
    std::vector<UpdateReport> update(const ChangeSet& changes, const std::vector<ViewUpdate>& views,
                                     cells::Control& control);

    /// Gathers what a checkpoint holds: films, histories and what they refer to. It must be written
    /// before the next update. Throws std::logic_error unless every film is that of the scene.
    void save(checkpoint::ArrayWriter& arrays) const;
    /// Makes this renderer, which has rendered nothing, the one that was saved, as far as films,
    /// histories and later updates go. `scene` is the change set that makes that one's scene from
    /// nothing; the views and options must be its own, and the `foreseen`. Throws
    /// std::runtime_error where `arrays` are not of that scene, or not whole; the renderer is then
    /// of no further use.
    void restore(const ChangeSet& scene, checkpoint::ArrayReader& arrays);

    [[nodiscard]] const film::Film& film(std::size_t view = 0) const {
        return views_.at(view)->view.film();
    }
    [[nodiscard]] const ViewSettings& settings(std::size_t view = 0) const {
        return views_.at(view)->view.settings();
    }
    /// View::motion; `changes` lead to the other state of the scene, in which the view's camera is
    /// `camera`, if that differs.
    [[nodiscard]] std::vector<V2f> motion(const ChangeSet& changes,
                                          const std::optional<Camera>& camera,
                                          std::size_t view = 0) const;
    /// The name behind a pixel's cause: of an object, material or light; empty of other causes.
    [[nodiscard]] std::string cause_name(film::CauseCode cause) const;
    /// The names of objects (or materials) that Cryptomatte shows under `ids`; of several that
    /// share one the least.
    [[nodiscard]] std::map<std::uint32_t, std::string> names(film::Aov kind,
                                                             std::set<std::uint32_t> ids) const;
    [[nodiscard]] film::PixelValue brute_force_pixel(int x, int y, std::size_t view = 0) const;
    /// For tests: checks all that holds of the histories after an update, where any is kept. Throws
    /// std::logic_error naming the first invariant that is broken, and where.
    void validate() const;
    /// Whether a view was left out of the last update that changed the scene, and the next one can
    /// make up for it.
    [[nodiscard]] bool catches_up(std::size_t view) const { return views_.at(view)->behind; }

  private:
    struct ViewState {
        View view;
        bool begun = false;  ///< it was rendered before, or tried
        bool film_is_current = false;
        bool behind = false;  ///< current but for `missed_`
        update::Backoff backoff{};
        std::uint64_t film_rays = 0;
    };
    /// What an update changed of the scene, for every view alike.
    struct SceneUpdate {
        AppliedChanges applied;
        std::vector<trace::Box> old_boxes;
        std::vector<LightSlot> old_lights;
        bool first = false, foreseen = true;
    };
    template <class Archive, class State>
    static void archive(Archive& to, const std::string& name, State& state);
    Renderer(const FloatState& while_constructing, const Camera& camera,
             const ViewSettings& settings, const RendererOptions& options);
    void update_view(ViewState& state, const SceneUpdate& scene, bool was_current,
                     bool camera_changed, bool keep_history, cells::Control& control,
                     UpdateReport& report);

    RendererOptions options_;
    Scene scene_;
    trace::Intersector intersector_;
    std::vector<std::unique_ptr<ViewState>> views_;
    SceneUpdate missed_;  ///< the last update that changed the scene, where a view was left out
    std::vector<std::uint32_t> uncommitted_;   ///< object slots the trees have not taken up yet
    bool committed_ = false;                   ///< the trees have been built
    std::vector<std::string> changed_lights_;  ///< by the last update
    std::atomic<bool> updating_ = false;
};

}  // namespace irt
