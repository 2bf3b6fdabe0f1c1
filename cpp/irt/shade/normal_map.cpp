// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/normal_map.h"

#include <cmath>
#include <optional>
#include <string_view>

#include "irt/scene/primvar.h"

namespace irt::shade {

namespace {

/// The primvar nearest to the normal input, nodes' first slots first.
std::optional<std::string_view> primvar_behind(const Material& material, std::int32_t node) {
    if (node == ShadeNode::unconnected) return std::nullopt;
    const ShadeNode& from = material.nodes[static_cast<std::size_t>(node)];
    if (from.op == Op::Primvar) return from.primvar;
    for (const std::int32_t input : from.inputs)
        if (const auto found = primvar_behind(material, input)) return found;
    return std::nullopt;
}

struct Frame {
    V3d tangent, bitangent;
};

std::optional<Frame> tangent_frame(const Material& material, const graph::Site& site,
                                   const M44d& render_from_trace,
                                   const trace::SurfacePoint& point) {
    const Triangles* const triangles = site.surface.triangles.get();
    if (!triangles) return std::nullopt;
    const std::string_view name =
        primvar_behind(material, material.connection(SurfaceInput::Normal).node).value_or("st");
    const Primvar* const st = find_primvar(triangles->mesh->primvars, name);
    if (!st || st->width < 2) return std::nullopt;
    const auto [a, b, c] = corner_values(*triangles, *st, site.hit.primitive);
    const double s1 = b[0] - a[0], t1 = b[1] - a[1], s2 = c[0] - a[0], t2 = c[1] - a[1];
    const double area = s1 * t2 - s2 * t1;
    if (!(area != 0)) return std::nullopt;

    const auto& v = triangles->triangles[site.hit.primitive];
    const V3d origin(triangles->points[v[0]]);
    V3d to_b = V3d(triangles->points[v[1]]) - origin, to_c = V3d(triangles->points[v[2]]) - origin;
    to_b = transform_direction(render_from_trace, to_b);
    to_c = transform_direction(render_from_trace, to_c);
    // The direction of growing s, whatever the size of the area.
    const V3d& normal = point.shading_normal;
    V3d tangent = (to_b * t2 - to_c * t1) * (area > 0 ? 1.0 : -1.0);
    tangent -= normal * tangent.dot(normal);
    const double squared = tangent.dot(tangent);
    if (!(squared > 0) || !std::isfinite(squared)) return std::nullopt;
    tangent = divided(tangent, std::sqrt(squared));
    // An instance may be mirrored: its triangles then wind the other way around.
    const bool mirrored = to_b.cross(to_c).dot(point.geometric_normal) < 0;
    return Frame{tangent, normal.cross(tangent) * ((area > 0) != mirrored ? 1.0 : -1.0)};
}

}  // namespace

V3d mapped_normal(const Material& material, const graph::Site& site, const M44d& render_from_trace,
                  const trace::SurfacePoint& point, const V3d& tangent_space) {
    const std::optional<Frame> frame = tangent_frame(material, site, render_from_trace, point);
    if (!frame) return point.shading_normal;
    const V3d mapped = frame->tangent * tangent_space.x + frame->bitangent * tangent_space.y +
                       point.shading_normal * tangent_space.z;
    const double squared = mapped.dot(mapped);
    if (!(squared > 0) || !std::isfinite(squared)) return point.shading_normal;
    return divided(mapped, std::sqrt(squared));
}

}  // namespace irt::shade
