// SPDX-License-Identifier: Apache-2.0
// One primitive before its scalar judge. A hit is a pure function of ray and primitive (DESIGN 3,
// rule 1), so that what is kept of it need not be more than its name.
#pragma once

#include "irt/scene/scene.h"
#include "irt/trace/judge_many.h"
#include "irt/trace/judge_triangle.h"
#include "irt/trace/ray.h"

namespace irt::trace {

/// Judges a quadric, ball or segment, as below.
inline bool judge_solid(const Surface& surface, std::uint32_t primitive, const JudgeRay& ray,
                        Hit& hit) {
    const M44d& shape_from_trace = surface.shape_from_trace;
    SolidHit met;
    if (surface.spheres) {
        if (!judge_ball(*surface.spheres, primitive, shape_from_trace, ray, met)) return false;
    } else if (surface.curves) {
        if (!judge_segment(*surface.curves, primitive, shape_from_trace, ray, met)) return false;
    } else if (!judge_quadric(surface.quadric, shape_from_trace, ray, met)) {
        return false;
    }
    hit.t = met.t;
    hit.u = met.u;
    hit.primitive = primitive;
    hit.piece = met.piece;
    return true;
}

/// Judges `primitive` of `surface` (a triangle, ball or segment; 0 for a quadric); true where
/// `ray`, in the surface's trace space, meets it within its limits. Fills t, u, v, primitive and
/// piece of `hit`.
inline bool judge_primitive(const Surface& surface, std::uint32_t primitive, const JudgeRay& ray,
                            Hit& hit) {
    if (!surface.triangles) return judge_solid(surface, primitive, ray, hit);
    const Triangles& mesh = *surface.triangles;
    const auto& v = mesh.triangles[primitive];
    TriangleHit met;
    if (!judge_triangle(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], ray, met))
        return false;
    if (!(met.t > 0 && met.t < ray.t_max) || (mesh.mesh->single_sided && !met.front)) return false;
    hit.t = met.t;
    hit.u = met.u;
    hit.v = met.v;
    hit.primitive = primitive;
    return true;
}

/// The name of a hit; `object` is `none` where there is none.
struct HitName {
    std::uint32_t object = none, part = 0, primitive = 0;

    HitName() = default;
    explicit HitName(const Hit& hit)
        : object(hit.object), part(hit.part), primitive(hit.primitive) {}
};

/// The hit of that name, as any query along `ray` gave it. Its object must not have changed since.
inline Hit named_hit(const Scene& scene, const Ray& ray, const HitName& name) {
    Hit hit;
    if (name.object == none) return hit;
    JudgeRay judged = judge_ray(ray);
    hit.object = name.object;
    hit.part = name.part;
    const CompiledPrototype* prototype = scene.prototype(name.object);
    if (!prototype) {
        judge_primitive(scene.object(name.object).surface, name.primitive, judged, hit);
        return hit;
    }
    transform_ray(scene.prototype_from_render(name.object), JudgeRay(judged), judged);
    const Surface& surface =
        prototype->part(name.part, [&](const NestedArray& array, std::uint32_t entry) {
            transform_ray(inverse_of(array.outer_from_prototype(entry)), JudgeRay(judged), judged);
        });
    judge_primitive(surface, name.primitive, judged, hit);
    return hit;
}

}  // namespace irt::trace
