// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/footprint.h"

#include <algorithm>
#include <cmath>

namespace irt::shade {

FootprintAxes footprint_axes(const V3d& direction, const V3d& normal, double width) {
    const double cosine = direction.dot(normal);
    V3d along = direction - normal * cosine;
    double size = along.dot(along);
    if (!(size > 1e-24)) {
        // Head on the ellipse is a circle: any two directions are its axes.
        const V3d other = std::fabs(normal.x) < 0.5 ? V3d(1, 0, 0) : V3d(0, 1, 0);
        along = other - normal * other.dot(normal);
        size = along.dot(along);
    }
    along = divided(along, std::sqrt(size));
    return {along * (width / std::max(std::fabs(cosine), least_cosine)),
            normal.cross(along) * width};
}

void set_footprint(const V3d& direction, const V3d& normal, double width,
                   const M44d& render_from_trace, graph::Site& site) {
    const Triangles* const triangles = site.surface.triangles.get();
    if (!triangles) return;
    FootprintAxes axes = footprint_axes(direction, normal, width);
    const M44d trace_from_render = inverse_of(render_from_trace);
    axes.along = transform_direction(trace_from_render, axes.along);
    axes.across = transform_direction(trace_from_render, axes.across);
    const auto& v = triangles->triangles[site.hit.primitive];
    const V3d a(triangles->points[v[0]]);
    const V3d to_b = V3d(triangles->points[v[1]]) - a, to_c = V3d(triangles->points[v[2]]) - a;
    const V3d area = to_b.cross(to_c);
    const double squared = area.dot(area);
    if (!(squared > 0)) return;
    const auto u = [&](const V3d& p) { return p.cross(to_c).dot(area) / squared; };
    const auto w = [&](const V3d& p) { return to_b.cross(p).dot(area) / squared; };
    site.u_x = u(axes.along);
    site.v_x = w(axes.along);
    site.u_y = u(axes.across);
    site.v_y = w(axes.across);
}

}  // namespace irt::shade
