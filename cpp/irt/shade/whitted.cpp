// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/whitted.h"

#include <algorithm>

#include "irt/shade/fresh_stack.h"
#include "irt/shade/recorder.h"
#include "irt/trace/brute_force.h"

namespace irt::shade {

Counts& Counts::operator+=(const Counts& other) {
    primary += other.primary;
    reflected += other.reflected;
    refracted += other.refracted;
    shadow += other.shadow;
    shadings += other.shadings;
    queries.nearest += other.queries.nearest;
    queries.occlusion += other.queries.occlusion;
    queries.candidates += other.queries.candidates;
    return *this;
}

template <class Source>
Scratch Whitted<Source>::make_scratch() const {
    Scratch scratch;
    scratch.columns.resize(lights().size() * (static_cast<std::size_t>(shading_.max_depth()) + 1));
    return scratch;
}

template <class Source>
V3f Whitted<Source>::sample(const trace::Ray& ray, Scratch& scratch) const {
    scratch.first = {};
    ++scratch.counts.primary;
    scratch.tree.clear(1 + lights().size());
    // The unscaled term, then the lights in path order: each energy times its response.
    V3d sum(trace(ray, 0, 0, 0, scratch));
    for (std::size_t l = 0; l < lights().size(); ++l)
        sum += V3d(lights()[l].record.energy) * V3d(scratch.columns[l]);
    return V3f(sum);
}

/// Traces `ray` and everything it spawns. Returns the unscaled term; the lights' columns are left
/// in this depth's level of the scratch.
template <class Source>
V3f Whitted<Source>::trace(const trace::Ray& ray, int depth, std::int64_t cost, double travelled,
                           Scratch& scratch) const {
    V3f* columns = level(scratch, depth);
    std::fill(columns, columns + lights().size(), V3f(0, 0, 0));
    const SampleTree::Handle node = scratch.tree_wanted ? scratch.tree.add() : 0;
    const trace::Hit hit = source_.nearest(ray, scratch.counts.queries);
    if (!hit) {
        for (std::size_t l = 0; l < lights().size(); ++l)
            columns[l] = shading_.seen_beyond(lights()[l], ray);
        if (scratch.tree_wanted) keep(node, SampleTree::Cumulative, V3f(0, 0, 0), columns, scratch);
        return {0, 0, 0};
    }

    const VisiblePoint point = shading_.visible_point(ray, hit, travelled);
    if (!scratch.first && !point.response().invisible()) {
        if (scratch.surface_wanted)
            scratch.first = Shading::first_hit(point, hit);
        else
            scratch.first = {hit, point.surface.material, point.matte, {}, {}, {}};
    }
    shade_lights(point, columns, scratch);
    V3f unscaled(point.response().emission);
    if (scratch.tree_wanted) {
        scratch.tree.meet(node, point.response().presence < 1);
        keep(node, SampleTree::Own, unscaled, columns, scratch);
        keep(node, SampleTree::Cumulative, unscaled, columns, scratch);
    }
    if (depth == shading_.max_depth()) return unscaled;
    const Spawned rays = shading_.spawned(point);
    if (shading_.any_varies()) travelled += Shading::length(ray, hit.t);
    branch(point, rays.reflect_direction, rays.reflect_weight, depth, cost, travelled, unscaled,
           scratch.counts.reflected, node, 0, scratch);
    branch(point, rays.refract_direction, rays.refract_weight, depth, cost, travelled, unscaled,
           scratch.counts.refracted, node, 1, scratch);
    if (scratch.tree_wanted) keep(node, SampleTree::Cumulative, unscaled, columns, scratch);
    return unscaled;
}

/// Keeps a node's intensities.
template <class Source>
void Whitted<Source>::keep(SampleTree::Handle node, SampleTree::Value value, const V3f& unscaled,
                           const V3f* columns, Scratch& scratch) const {
    scratch.tree.set(node, value, 0, unscaled);
    for (std::size_t l = 0; l < lights().size(); ++l)
        scratch.tree.set(node, value, 1 + l, columns[l]);
}

/// Traces one branch of the node at `depth` unless it is cut, and adds its cumulative intensity to
/// the node's.
template <class Source>
void Whitted<Source>::branch(const VisiblePoint& point, const V3d& direction, const V3d& weight,
                             int depth, std::int64_t cost, double travelled, V3f& unscaled,
                             std::uint64_t& kind, SampleTree::Handle node, int which,
                             Scratch& scratch) const {
    const V3f share(weight);
    const std::optional<std::int64_t> own = price(share);
    if (!own || !shading_.affordable(cost + *own)) return;
    ++kind;
    const SampleTree::Handle branch = scratch.tree.end();
    const V3f below = with_stack_for(depth + 1, [&] {
        return trace(shading_.spawned_ray(point, direction), depth + 1, cost + *own, travelled,
                     scratch);
    });
    if (scratch.tree_wanted) scratch.tree.join(node, which, branch, share);
    V3f *columns = level(scratch, depth), *columns_below = level(scratch, depth + 1);
    for (std::size_t l = 0; l < lights().size(); ++l)
        columns[l] = add_scaled(columns[l], share, columns_below[l]);
    unscaled = add_scaled(unscaled, share, below);
}

/// The unit-energy response of the visible point to each light.
template <class Source>
void Whitted<Source>::shade_lights(const VisiblePoint& point, V3f* columns,
                                   Scratch& scratch) const {
    ++scratch.counts.shadings;
    for (std::size_t l = 0; l < lights().size(); ++l) {
        const std::optional<LightSample> sample = shading_.light_sample(point, lights()[l]);
        if (!sample) continue;
        V3d response = sample->response;
        if (sample->shadow_ray) {
            ++scratch.counts.shadow;
            response *= shadowed(
                lights()[l].record,
                source_.occlusion(*sample->shadow_ray, scratch.counts.queries, lights()[l].rule()));
        }
        columns[l] = V3f(response);
    }
}

template class Whitted<trace::Intersector>;
template class Whitted<trace::BruteForce>;
template class Whitted<Recorder>;

}  // namespace irt::shade
