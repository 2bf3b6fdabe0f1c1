// SPDX-License-Identifier: Apache-2.0
// A hit's surface, recomputed in double, with a bound on what rounding did to it.
#include <algorithm>
#include <cmath>

#include "irt/trace/intersector.h"
#include "irt/trace/judge_many.h"

namespace irt::trace {
namespace {

/// Rounding of one double operation, relative.
constexpr double unit = 0x1p-53;

/// Operations a coordinate goes through in one step below, and as many again for what the judge
/// rounds when a ray from here comes before it: a barycentric sum, a projection onto a piece, or an
/// affine transform each cost a coordinate at most 8 roundings of its largest term.
constexpr double step_error = 16 * unit;

double largest(const V3d& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

/// The largest coordinate of the terms summed in transform_point(m, p).
double term_size(const M44d& m, const V3d& p) {
    double most = 0;
    for (int a = 0; a < 3; ++a)
        most = std::max(most, std::fabs(p.x * m[0][a]) + std::fabs(p.y * m[1][a]) +
                                  std::fabs(p.z * m[2][a]) + std::fabs(m[3][a]));
    return most;
}

/// By how much `m` can enlarge an error bounded coordinate by coordinate.
double gain(const M44d& m) {
    double most = 0;
    for (int a = 0; a < 3; ++a)
        most = std::max(most, std::fabs(m[0][a]) + std::fabs(m[1][a]) + std::fabs(m[2][a]));
    return most;
}

/// A position in some space with the bound on its coordinates' error there.
struct Bounded {
    V3d position;
    double error;
};

/// `p` in space a. The error holds what the transform rounds, and what its inverse rounds when a
/// ray that starts here is brought back to space b.
Bounded transformed(const M44d& a_from_b, const M44d& b_from_a, const Bounded& p) {
    const V3d q = transform_point(a_from_b, p.position);
    const double there_and_back = p.error + step_error * term_size(b_from_a, q);
    return {q, gain(a_from_b) * there_and_back + step_error * term_size(a_from_b, p.position)};
}

V3d unit_vector(const V3d& v) {
    // Scaled first: a tiny or huge normal must not vanish or overflow when squared.
    const double size = largest(v);
    if (!(size > 0) || !std::isfinite(size)) return {0, 0, 0};
    return normalized(divided(v, size));
}

struct Local {
    Bounded point;
    V3d geometric{0, 0, 0}, shading{0, 0, 0};  ///< normals, of any length; shading may be zero
};

V3d authored_normal(const Triangles& triangles, const Hit& hit) {
    const Mesh& mesh = *triangles.mesh;
    const auto normal = [&](std::size_t index) { return V3d(mesh.normals[index]); };
    const auto& corners = triangles.corners[hit.primitive];
    const auto blend = [&](std::size_t a, std::size_t b, std::size_t c) {
        return normal(a) * (1 - hit.u - hit.v) + normal(b) * hit.u + normal(c) * hit.v;
    };
    const auto vertex = [&](std::size_t corner) {
        return static_cast<std::size_t>(mesh.face_vertex_indices[corner]);
    };
    switch (mesh.normals_interpolation) {
        case Interpolation::None:
            break;
        case Interpolation::Constant:
            return normal(0);
        case Interpolation::Uniform:
            return normal(triangles.faces[hit.primitive]);
        case Interpolation::Varying:
        case Interpolation::Vertex:
            return blend(vertex(corners[0]), vertex(corners[1]), vertex(corners[2]));
        case Interpolation::FaceVarying:
            return blend(corners[0], corners[1], corners[2]);
    }
    return {0, 0, 0};
}

void on_triangle(const Surface& surface, const Hit& hit, Local& local) {
    const Triangles& triangles = *surface.triangles;
    const auto& v = triangles.triangles[hit.primitive];
    const V3d a(triangles.points[v[0]]), b(triangles.points[v[1]]), c(triangles.points[v[2]]);
    local.point.position = a * (1 - hit.u - hit.v) + b * hit.u + c * hit.v;
    local.point.error = step_error * std::max({largest(a), largest(b), largest(c)});
    local.geometric = (b - a).cross(c - a);
    if (triangles.mesh->normals_interpolation != Interpolation::None)
        local.shading = transform_normal(surface.shape_from_trace, authored_normal(triangles, hit));
}

/// `o` and `d`: the ray in trace space.
void on_solid(const Surface& surface, const Hit& hit, const V3d& o, const V3d& d, Local& local) {
    const V3d p = transform_point(surface.shape_from_trace, o) +
                  transform_direction(surface.shape_from_trace, d) * hit.t;
    ShapePoint on;
    double size = 0;
    if (surface.spheres) {
        const ExactBall ball(surface.spheres->balls[hit.primitive]);
        on = on_ball(ball, p);
        size = largest(ball.centre) + ball.radius;
    } else if (surface.curves) {
        const Curves& curves = *surface.curves;
        const ExactBall a(curves.balls[hit.primitive]),
            b(curves.balls[curves.next_ball(hit.primitive)]);
        on = on_round_cone(a, b, hit.piece, p);
        size = std::max(largest(a.centre) + a.radius, largest(b.centre) + b.radius);
    } else {
        const Quadric& q = surface.quadric;
        on = on_quadric(q, hit.piece, p);
        size = std::max({largest(on.position), q.radius, q.radius_top, q.height / 2});
    }
    local.point = transformed(surface.trace_from_shape, surface.shape_from_trace,
                              {on.position, step_error * size});
    local.geometric = transform_normal(surface.shape_from_trace, on.normal);
}

void on_surface(const Surface& surface, const Hit& hit, const V3d& o, const V3d& d, Local& local) {
    if (surface.triangles)
        on_triangle(surface, hit, local);
    else
        on_solid(surface, hit, o, d, local);
}

/// Brings `local` from an instance's space to the one it is in.
void leave_instance(const M44d& outer_from_inner, const M44d& inner_from_outer, Local& local) {
    local.point = transformed(outer_from_inner, inner_from_outer, local.point);
    local.geometric = transform_normal(inner_from_outer, local.geometric);
    local.shading = transform_normal(inner_from_outer, local.shading);
}

/// On part `number` of a prototype, in its space, and so are `o` and `d`.
const Surface& on_part(const CompiledPrototype& prototype, std::uint32_t number, const Hit& hit,
                       const V3d& o, const V3d& d, Local& local) {
    if (number < prototype.surfaces.size()) {
        on_surface(prototype.surfaces[number], hit, o, d, local);
        return prototype.surfaces[number];
    }
    const auto [array, entry, inner] = prototype.locate(number);
    const M44d outer_from_inner = array->outer_from_prototype(entry);
    const M44d inner_from_outer = inverse_of(outer_from_inner);
    const Surface& surface =
        on_part(array->prototype(entry), inner, hit, transform_point(inner_from_outer, o),
                transform_direction(inner_from_outer, d), local);
    leave_instance(outer_from_inner, inner_from_outer, local);
    return surface;
}

}  // namespace

SurfacePoint surface_point(const Scene& scene, const Ray& ray, const Hit& hit) {
    const V3d o(ray.origin), d(ray.direction);
    Local local;
    const Surface* seen = &scene.object(hit.object).surface;
    if (const CompiledPrototype* prototype = scene.prototype(hit.object)) {
        const M44d prototype_from_render = scene.prototype_from_render(hit.object);
        seen = &on_part(*prototype, hit.part, hit, transform_point(prototype_from_render, o),
                        transform_direction(prototype_from_render, d), local);
        leave_instance(scene.render_from_prototype(hit.object), prototype_from_render, local);
    } else {
        on_surface(*seen, hit, o, d, local);
    }
    const Surface& surface = *seen;
    SurfacePoint point;
    point.position = local.point.position;
    point.error = local.point.error;
    point.geometric_normal = unit_vector(local.geometric);
    point.shading_normal = unit_vector(local.shading);
    if (point.shading_normal == V3d(0, 0, 0)) point.shading_normal = point.geometric_normal;
    if (point.shading_normal.dot(point.geometric_normal) < 0)
        point.shading_normal = -point.shading_normal;
    point.front = V3d(ray.direction).dot(point.geometric_normal) < 0;
    point.material = surface.material_of(hit.primitive);
    return point;
}

}  // namespace irt::trace
