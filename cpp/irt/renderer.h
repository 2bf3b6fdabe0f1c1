// SPDX-License-Identifier: Apache-2.0
// The facade: one scene, its trees, and a view of it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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

class Renderer {
  public:
    Renderer(const Camera& camera, const ViewSettings& settings, const RendererOptions& options);

    /// Applies `changes` and `camera` and brings the film up to them. An update that changes
    /// nothing traces nothing. Throws std::invalid_argument on records that cannot be rendered;
    /// nothing is then applied. A stopped update leaves the last whole film; the next one makes up
    /// for it. `keep_history` false: a full trace records nothing, for the caller knows that the
    /// next update could not use it. Throws std::logic_error if called while an update runs.
    UpdateReport update(const ChangeSet& changes, const std::optional<Camera>& camera,
                        bool keep_history, cells::Control& control);

    [[nodiscard]] const film::Film& film() const { return view_.film(); }
    [[nodiscard]] film::PixelValue brute_force_pixel(int x, int y) const;
    /// For tests: checks all that holds of a history after an update, where one is kept. Throws
    /// std::logic_error naming the first invariant that is broken, and where.
    void validate() const;

  private:
    Renderer(const FloatState& while_constructing, const Camera& camera,
             const ViewSettings& settings, const RendererOptions& options);

    RendererOptions options_;
    Scene scene_;
    trace::Intersector intersector_;
    View view_;
    std::vector<std::uint32_t> uncommitted_;  ///< object slots the trees have not taken up yet
    bool film_is_current_ = false;
    update::Backoff backoff_;
    std::atomic<bool> updating_ = false;
    std::uint64_t film_rays_ = 0;
};

}  // namespace irt
