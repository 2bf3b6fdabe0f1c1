// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/same_point.h"

#include <algorithm>

#include "irt/math/bits.h"
#include "irt/scene/placement.h"

namespace irt::trace {

namespace {

/// Whether primitives of the same number are the same piece of surface.
bool same_topology(const Surface& a, const Surface& b) {
    if (a.triangles && b.triangles) {
        const Mesh &p = *a.triangles->mesh, &q = *b.triangles->mesh;
        return &p == &q || (p.points.size() == q.points.size() &&
                            same_bits(p.face_vertex_counts, q.face_vertex_counts) &&
                            same_bits(p.face_vertex_indices, q.face_vertex_indices));
    }
    if (a.spheres && b.spheres) return a.spheres->balls.size() == b.spheres->balls.size();
    if (a.curves && b.curves)
        return a.curves->closed == b.curves->closed &&
               same_bits(a.curves->firsts, b.curves->firsts);
    return !a.triangles && !b.triangles && !a.spheres && !b.spheres && !a.curves && !b.curves &&
           a.quadric.kind == b.quadric.kind;
}

V3d half_extent(const Quadric& q) {
    switch (q.kind) {
        case QuadricKind::Sphere:
            return V3d(q.radius);
        case QuadricKind::Cube:
            return V3d(q.size / 2);
        case QuadricKind::Plane:
            return {q.width / 2, q.length / 2, 1};
        case QuadricKind::Capsule:
            return {q.radius, q.radius, q.height / 2 + q.radius};
        case QuadricKind::Cylinder:
        case QuadricKind::Cone:
            return {q.radius, q.radius, q.height / 2};
        case QuadricKind::Frustum:
        case QuadricKind::RoundCone:
            break;
    }
    const double radius = std::max(q.radius, q.radius_top);
    return {radius, radius, q.height / 2};
}

/// `p` about `from`, brought about `to`.
V3d carried(const V3d& p, const Ball& from, const Ball& to) {
    const double scale =
        from.radius > 0 ? static_cast<double>(to.radius) / static_cast<double>(from.radius) : 1;
    return V3d(to.centre) + (p - V3d(from.centre)) * scale;
}

Ball between(const Curves& curves, std::uint32_t segment, double u) {
    const Ball &a = curves.balls[segment], &b = curves.balls[curves.next_ball(segment)];
    return {V3f(V3d(a.centre) * (1 - u) + V3d(b.centre) * u),
            static_cast<float>(static_cast<double>(a.radius) * (1 - u) +
                               static_cast<double>(b.radius) * u)};
}

/// `p` on `a`, in its shape's space, on `b`.
V3d moved(const Surface& a, const Surface& b, const Hit& hit, const V3d& p) {
    if (a.spheres)
        return carried(p, a.spheres->balls[hit.primitive], b.spheres->balls[hit.primitive]);
    if (a.curves)
        return carried(p, between(*a.curves, hit.primitive, hit.u),
                       between(*b.curves, hit.primitive, hit.u));
    const V3d from = half_extent(a.quadric), to = half_extent(b.quadric);
    V3d q = p;
    for (int c = 0; c < 3; ++c)
        if (from[c] > 0) q[c] *= to[c] / from[c];
    return q;
}

}  // namespace

std::optional<V3d> SamePoint::find(const Hit& hit, const V3d& position) {
    const auto [entry, fresh] = known_.try_emplace({hit.object, hit.part}, false);
    if (fresh) entry->second = corresponds(hit);
    if (!entry->second) return std::nullopt;
    const Surface &a = now_.surface(hit.object, hit.part),
                  &b = other_.surface(hit.object, hit.part);
    const M44d render_from_there = other_.render_from_trace(hit.object, hit.part);
    if (a.triangles) {
        const auto& v = a.triangles->triangles[hit.primitive];
        const auto corner = [&](std::size_t c) { return V3d(b.triangles->points[v[c]]); };
        return transform_point(render_from_there, corner(0) * (1 - hit.u - hit.v) +
                                                      corner(1) * hit.u + corner(2) * hit.v);
    }
    const M44d here_from_render = inverse_of(now_.render_from_trace(hit.object, hit.part));
    const V3d p = transform_point(a.shape_from_trace, transform_point(here_from_render, position));
    return transform_point(render_from_there,
                           transform_point(b.trace_from_shape, moved(a, b, hit, p)));
}

bool SamePoint::corresponds(const Hit& hit) {
    if (!other_.live(hit.object)) return false;
    const CompiledPrototype *a = now_.prototype(hit.object), *b = other_.prototype(hit.object);
    if ((a == nullptr) != (b == nullptr) || (a && a->parts != b->parts)) return false;
    return same_topology(now_.surface(hit.object, hit.part), other_.surface(hit.object, hit.part));
}

}  // namespace irt::trace
