// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/equality.h"

#include <algorithm>
#include <cstring>

#include "irt/math/bits.h"

namespace irt {

bool same(const Prototype& a, const Prototype& b) {
    if (a.parts.size() != b.parts.size()) return false;
    for (std::size_t i = 0; i < a.parts.size(); ++i) {
        const Part &p = a.parts[i], &q = b.parts[i];
        if (p.name != q.name || p.material != q.material || p.face_materials != q.face_materials ||
            p.role != q.role || !same_bits(p.prototype_from_part, q.prototype_from_part) ||
            !same(p.geometry, q.geometry) || !same(p.primvars, q.primvars))
            return false;
    }
    return true;
}

namespace {

bool same(const InstanceArray& a, const InstanceArray& b) {
    return std::equal(a.prototypes.begin(), a.prototypes.end(), b.prototypes.begin(),
                      b.prototypes.end(),
                      [](const auto& p, const auto& q) { return p == q || same(*p, *q); }) &&
           same_bits(a.prototype_of, b.prototype_of) && same_bits(a.keys, b.keys) &&
           same_bits(a.array_from_prototype, b.array_from_prototype) &&
           same(a.primvars, b.primvars);
}

/// The place of the value that entry `entry` has.
std::size_t value_of(const Primvar& primvar, std::size_t entry) {
    if (primvar.interpolation == Interpolation::Constant) entry = 0;
    return primvar.indices.empty() ? entry : static_cast<std::size_t>(primvar.indices[entry]);
}

}  // namespace

bool same_primvars(const InstanceArray& a, std::size_t i, const InstanceArray& b, std::size_t j) {
    return std::equal(a.primvars.begin(), a.primvars.end(), b.primvars.begin(), b.primvars.end(),
                      [&](const Primvar& p, const Primvar& q) {
                          if (p.name != q.name || p.width != q.width) return false;
                          const auto width = static_cast<std::size_t>(p.width);
                          return std::memcmp(p.values.data() + width * value_of(p, i),
                                             q.values.data() + width * value_of(q, j),
                                             width * sizeof(float)) == 0;
                      });
}

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
           same_bits(a.face_materials, b.face_materials) && same_bits(a.elements, b.elements);
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

bool same(const IesWeb& a, const IesWeb& b) {
    return same_bits(a.vertical, b.vertical) && same_bits(a.horizontal, b.horizontal) &&
           same_bits(a.values, b.values);
}

bool same(const Light& a, const Light& b) {
    return same_but_energy(a, b) && same_bits(a.energy, b.energy);
}

bool same_but_energy(const Light& a, const Light& b) {
    return same_response(a, b) && same_sky(a, b) && a.unlit == b.unlit &&
           a.shadowless == b.shadowless;
}

bool same_sky(const Light& a, const Light& b) {
    if (a.sky == b.sky || !a.sky || !b.sky) return a.sky == b.sky;
    return (a.sky->texture == b.sky->texture || same(*a.sky->texture, *b.sky->texture)) &&
           same_bits(a.sky->x, b.sky->x) && same_bits(a.sky->y, b.sky->y) &&
           same_bits(a.sky->z, b.sky->z);
}

bool same_response(const Light& a, const Light& b) {
    return same_rays(a, b) && a.profile == b.profile && same_bits(a.side, b.side) &&
           same_bits(a.direction, b.direction) && same_bits(a.diffuse, b.diffuse) &&
           same_bits(a.specular, b.specular) && same_bits(a.cone_angle, b.cone_angle) &&
           same_bits(a.cone_softness, b.cone_softness) && same_bits(a.focus, b.focus) &&
           same_bits(a.focus_tint, b.focus_tint) && same_bits(a.shadow_color, b.shadow_color) &&
           same_bits(a.facets, b.facets) &&
           (a.ies == b.ies || (a.ies && b.ies && same(*a.ies, *b.ies)));
}

bool same_rays(const Light& a, const Light& b) {
    return a.kind == b.kind &&
           (a.kind != LightKind::Distant || same_bits(a.direction, b.direction)) &&
           same_bits(a.position, b.position) && a.casts_shadows == b.casts_shadows &&
           a.camera_visible == b.camera_visible &&
           same_bits(a.shadow_distance, b.shadow_distance) &&
           same_bits(a.shadow_falloff, b.shadow_falloff) &&
           same_bits(a.shadow_falloff_gamma, b.shadow_falloff_gamma);
}

bool same(const Camera& a, const Camera& b) {
    return same_bits(a.world_from_camera, b.world_from_camera) &&
           a.orthographic == b.orthographic && same_bits(a.window, b.window) &&
           same_bits(a.near, b.near) && same_bits(a.far, b.far);
}

}  // namespace irt
