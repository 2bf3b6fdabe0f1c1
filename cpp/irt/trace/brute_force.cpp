// SPDX-License-Identifier: Apache-2.0
// The twin without trees: every primitive of the scene goes before the scalar judges.
#include "irt/trace/candidate.h"
#include "irt/trace/intersector.h"
#include "irt/trace/judge_quadric.h"
#include "irt/trace/judge_triangle.h"

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
            Hit hit;
            hit.object = slot;
            hit.part = part;
            if (!surface.triangles) {
                QuadricHit met;
                if (!judge_quadric(surface.quadric, surface.shape_from_trace, local, met)) continue;
                hit.t = met.t;
                hit.piece = met.piece;
                if (found(hit)) return;
                continue;
            }
            const Triangles& mesh = *surface.triangles;
            for (std::uint32_t k = 0; k < mesh.triangles.size(); ++k) {
                const auto& v = mesh.triangles[k];
                TriangleHit met;
                if (!judge_triangle(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], local,
                                    met))
                    continue;
                if (!(met.t > 0 && met.t < local.t_max)) continue;
                if (mesh.mesh->single_sided && !met.front) continue;
                hit.t = met.t;
                hit.u = met.u;
                hit.v = met.v;
                hit.primitive = k;
                if (found(hit)) return;
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
    for_each_hit(scene, ray,
                 [&](const Hit& hit) { return add_occluder(scene, hit.object, hit.part, sum); });
    return sum;
}

}  // namespace irt::trace
