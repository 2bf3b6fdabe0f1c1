// SPDX-License-Identifier: Apache-2.0
// How judged candidates compare and combine; shared by the Embree path and its brute-force twin.
#pragma once

#include <algorithm>
#include <bit>

#include "irt/graph/evaluate.h"
#include "irt/mutant.h"
#include "irt/scene/scene.h"
#include "irt/trace/ray.h"
#include "irt/trace/shadow_rule.h"

namespace irt::trace {

/// Replaces `best` if `candidate` is nearer, or as near and first by (object, part, primitive).
/// A query starts with best.t at its t_max, object `none`: nothing at that distance is taken.
inline bool take_if_nearer(const Scene& scene, const Hit& candidate, Hit& best) {
    if (candidate.t > best.t) return false;
    if (candidate.t == best.t) {
        if (!best) return false;
        if (candidate.object != best.object ? scene.before(best.object, candidate.object)
            : candidate.part != best.part   ? candidate.part > best.part
                                            : candidate.primitive >= best.primitive)
            return false;
    }
    best = candidate;
    return true;
}

/// What `ray`, met at `hit` by a material whose tint varies, loses there.
[[nodiscard]] OpticalDepth local_tint(const Scene& scene, const MaterialSlot& material,
                                      const Surface& surface, const Ray& ray, const Hit& hit);

/// Adds one occluding primitive, met by `ray` (in render space) at `hit`; saturation keeps the sum
/// free of order. True once nothing passes. `rule`: the light's, or null.
inline bool add_occluder(const Scene& scene, const Ray& ray, const Hit& hit, Occlusion& sum,
                         const ShadowRule* rule = nullptr) {
    if (rule && !rule->casts(scene.object_index(hit.object))) return false;
    const Surface& surface = scene.surface(hit.object, hit.part);
    const MaterialSlot& material = scene.materials()[surface.material_of(hit.primitive)];
    OpticalDepth depth = material.tint_varies ? local_tint(scene, material, surface, ray, hit)
                                              : material.shadow_depth;
    if (rule && rule->falloff > 0) depth = rule->faded(depth, hit.t * V3d(ray.direction).length());
    bool opaque = true, black = true;
    for (int c = 0; c < 3; ++c) {
        opaque = opaque && depth.rgb[c] >= depth_opaque;
        sum.depth.rgb[c] =
            std::min(sum.depth.rgb[c] + std::min(depth.rgb[c], depth_opaque), depth_opaque);
        if (mutated(Mutant::tints_in_order) && sum.depth.rgb[c] < depth_opaque)
            sum.depth.rgb[c] &= ~(std::bit_floor(sum.depth.rgb[c]) / 16 - 1);
        black = black && sum.depth.rgb[c] == depth_opaque;
    }
    if (opaque) sum.blocker = hit.object;
    return black;
}

}  // namespace irt::trace
