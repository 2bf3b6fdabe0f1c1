// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/equality.h"

#include <algorithm>

#include "irt/math/bits.h"

namespace irt {

namespace {

bool same(const Prototype& a, const Prototype& b) {
    if (a.parts.size() != b.parts.size()) return false;
    for (std::size_t i = 0; i < a.parts.size(); ++i) {
        const Part &p = a.parts[i], &q = b.parts[i];
        if (p.name != q.name || p.material != q.material || p.face_materials != q.face_materials ||
            !same_bits(p.prototype_from_part, q.prototype_from_part) ||
            !same(p.geometry, q.geometry))
            return false;
    }
    return true;
}

}  // namespace

bool same(const Quadric& a, const Quadric& b) {
    return a.kind == b.kind && same_bits(a.radius, b.radius) && same_bits(a.height, b.height) &&
           same_bits(a.size, b.size) && same_bits(a.width, b.width) &&
           same_bits(a.length, b.length) && same_bits(a.radius_top, b.radius_top);
}

bool same(const Spheres& a, const Spheres& b) {
    return same_bits(a.balls, b.balls) && same(a.primvars, b.primvars);
}

bool same(const Curves& a, const Curves& b) {
    return a.closed == b.closed && same_bits(a.firsts, b.firsts) && same_bits(a.balls, b.balls) &&
           same(a.primvars, b.primvars);
}

bool same(const Primvars& a, const Primvars& b) {
    return std::equal(
        a.begin(), a.end(), b.begin(), b.end(), [](const Primvar& p, const Primvar& q) {
            return p.name == q.name && p.interpolation == q.interpolation && p.width == q.width &&
                   same_bits(p.values, q.values) && same_bits(p.indices, q.indices);
        });
}

bool same(const Mesh& a, const Mesh& b) {
    return same_hits(a, b) && a.normals_interpolation == b.normals_interpolation &&
           same_bits(a.normals, b.normals) && same(a.primvars, b.primvars) &&
           same_bits(a.face_materials, b.face_materials);
}

bool same_hits(const Mesh& a, const Mesh& b) {
    return a.left_handed == b.left_handed && a.single_sided == b.single_sided &&
           same_bits(a.points, b.points) && same_bits(a.face_vertex_counts, b.face_vertex_counts) &&
           same_bits(a.face_vertex_indices, b.face_vertex_indices);
}

bool same(const Geometry& a, const Geometry& b) {
    if (a.index() != b.index()) return false;
    return std::visit(
        [&b](const auto& x) {
            const auto& y = std::get<std::decay_t<decltype(x)>>(b);
            if constexpr (std::is_same_v<std::decay_t<decltype(x)>, Quadric>)
                return same(x, y);
            else
                return x == y || same(*x, *y);
        },
        a);
}

bool same(const Light& a, const Light& b) {
    return a.kind == b.kind && same_bits(a.direction, b.direction) &&
           same_bits(a.position, b.position) && same_bits(a.energy, b.energy) &&
           a.casts_shadows == b.casts_shadows;
}

bool same_rays(const Light& a, const Light& b) {
    Light other = b;
    other.energy = a.energy;
    return same(a, other);
}

bool same(const Camera& a, const Camera& b) {
    return same_bits(a.world_from_camera, b.world_from_camera) &&
           a.orthographic == b.orthographic && same_bits(a.window, b.window) &&
           same_bits(a.near, b.near) && same_bits(a.far, b.far);
}

}  // namespace irt
