// SPDX-License-Identifier: Apache-2.0
// What `irt bench trace` times: a render, and the queries of that render alone, through our
// intersector and through the bare loop (DESIGN 7).
#pragma once

#include <memory>

#include "irt/scene/scene.h"
#include "irt/shade/recorder.h"
#include "irt/trace/bare_loop.h"
#include "irt/trace/intersector.h"
#include "irt/view.h"

namespace irt {

enum class Loop { Bare, Ours };
enum class Query { Nearest, Occlusion };

class TraceBench {
  public:
    /// Builds the trees. Throws as Renderer and Renderer::update do.
    TraceBench(const ChangeSet& scene, const Camera& camera, const ViewSettings& settings,
               const V3d& render_origin, const std::string& isa);

    /// Seconds of a full trace into the film on `threads` threads: rays, shading, film; no trees.
    double render(int threads);

    /// One pass on the calling thread over the rays of one kind that a render traces, cell after
    /// cell. The first call records the rays and builds the bare loop's tree, outside the time.
    [[nodiscard]] trace::LoopTime time(Loop loop, Query query);

    /// The render's rays and work, counted while they were recorded.
    [[nodiscard]] const shade::Counts& counts();

    [[nodiscard]] const film::Film& film() const { return view_.film(); }

  private:
    struct Loops {
        shade::RayRecord rays;
        shade::Counts counts;
        trace::BareLoop bare;
    };
    Loops& loops();

    std::string isa_;
    Scene scene_;
    trace::Intersector intersector_;
    View view_;
    std::unique_ptr<Loops> loops_;
};

}  // namespace irt
