// SPDX-License-Identifier: Apache-2.0
// The twin without trees: every primitive of the scene goes before the scalar judges.
#include "irt/trace/candidate.h"
#include "irt/trace/intersector.h"
#include "irt/trace/judge_object.h"

namespace irt::trace {
namespace {

/// Calls found(hit) for every primitive that `ray` meets within its limits; stops when it says so.
template <class Found>
void for_each_hit(const Scene& scene, const Ray& ray, Found&& found) {
    const JudgeRay world = judge_ray(ray);
    for (std::uint32_t slot = 0; slot < scene.slot_count(); ++slot)
        if (scene.live(slot) && judge_object(scene, slot, world, ray.camera, found)) return;
}

}  // namespace

Hit brute_force_nearest(const Scene& scene, const Ray& ray) {
    Hit best;
    for_each_hit(scene, ray, [&](const Hit& hit) {
        if (best)
            take_if_nearer(scene, hit, best);
        else
            best = hit;
        return false;
    });
    return best;
}

Occlusion brute_force_occlusion(const Scene& scene, const Ray& ray, const ShadowRule* rule) {
    Occlusion sum;
    for_each_hit(scene, ray,
                 [&](const Hit& hit) { return add_occluder(scene, ray, hit, sum, rule); });
    return sum;
}

}  // namespace irt::trace
