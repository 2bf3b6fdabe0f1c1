// SPDX-License-Identifier: Apache-2.0
// The twin without trees: every primitive of the scene goes before the scalar judges.
#include "irt/trace/candidate.h"
#include "irt/trace/intersector.h"
#include "irt/trace/judge_primitive.h"

namespace irt::trace {
namespace {

/// Calls found(hit) for every primitive that `ray` meets within its limits; stops when it says so.
template <class Found>
void for_each_hit(const Scene& scene, const Ray& ray, Found&& found) {
    const JudgeRay world = judge_ray(ray);
    for (std::uint32_t slot = 0; slot < scene.objects().size(); ++slot) {
        const ObjectSlot& object = scene.objects()[slot];
        if (!object.live) continue;
        JudgeRay local = world;
        if (object.prototype) transform_ray(object.prototype_from_render, world, local);
        const std::size_t parts = object.prototype ? object.prototype->surfaces.size() : 1;
        for (std::uint32_t part = 0; part < parts; ++part) {
            const Surface& surface = object.part(part);
            const std::uint32_t primitives = primitive_count(surface);
            for (std::uint32_t k = 0; k < primitives; ++k) {
                Hit hit;
                hit.object = slot;
                hit.part = part;
                if (judge_primitive(surface, k, local, hit) && found(hit)) return;
            }
        }
    }
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

Occlusion brute_force_occlusion(const Scene& scene, const Ray& ray) {
    Occlusion sum;
    for_each_hit(scene, ray, [&](const Hit& hit) { return add_occluder(scene, hit, sum); });
    return sum;
}

}  // namespace irt::trace
