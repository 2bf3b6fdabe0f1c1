// SPDX-License-Identifier: Apache-2.0
#include "irt/trace_bench.h"

#include <chrono>
#include <utility>

#include "irt/math/float_state.h"

namespace irt {

TraceBench::TraceBench(const ChangeSet& scene, const Camera& camera, const ViewSettings& settings,
                       const V3d& render_origin, const std::string& isa)
    : isa_(isa), scene_(render_origin), intersector_(isa), view_(camera, settings, render_origin) {
    const FloatState ieee;
    intersector_.commit(scene_, scene_.apply(scene).geometry);
}

double TraceBench::render(int threads) {
    cells::Control control;
    CellReports reports;
    const auto start = std::chrono::steady_clock::now();
    view_.trace_all(scene_, intersector_, threads, cells::natural_order(), control, reports);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

trace::LoopTime TraceBench::time(Loop loop, Query query) {
    const FloatState ieee;
    const Loops& recorded = loops();
    if (query == Query::Nearest)
        return loop == Loop::Bare ? recorded.bare.nearest(recorded.rays.nearest)
                                  : trace::time_nearest(intersector_, recorded.rays.nearest);
    return loop == Loop::Bare ? recorded.bare.occlusion(recorded.rays.occlusion)
                              : trace::time_occlusion(intersector_, recorded.rays.occlusion);
}

const shade::Counts& TraceBench::counts() { return loops().counts; }

TraceBench::Loops& TraceBench::loops() {
    if (!loops_) {
        const FloatState ieee;
        shade::RayRecord rays;
        const shade::Counts counts = view_.record(scene_, intersector_, rays);
        loops_.reset(new Loops{std::move(rays), counts, trace::BareLoop(scene_, isa_)});
    }
    return *loops_;
}

}  // namespace irt
