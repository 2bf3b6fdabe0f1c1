// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/judge_quadric.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "irt/trace/interval.h"
#include "irt/trace/round_cone.h"

namespace irt::trace {
namespace {

/// x^2 + y^2 <= k^2 (apex - z)^2 below the apex.
void clip_side(Interval& in, const Line& l, double k, double apex, std::uint8_t piece) {
    clip_nappe(in, V3d(l.o.x, l.o.y, 0), V3d(l.d.x, l.d.y, 0), k * (apex - l.o.z), -k * l.d.z,
               piece);
}

/// Of the angle between a frustum's side and its axis. Radii, and what is measured across the axis,
/// are taken times the cosine, so that a flat frustum is as exact as a steep one.
struct Slant {
    double sine, cosine;
    explicit Slant(const Quadric& q) {
        const double rise = q.radius - q.radius_top;
        const double length = std::sqrt(rise * rise + q.height * q.height);
        sine = rise / length;
        cosine = q.height / length;
    }
};

void clip_frustum_side(Interval& in, const Line& l, const Quadric& q) {
    const Slant slant(q);
    const double middle = (q.radius + q.radius_top) / 2;
    clip_nappe(in, V3d(l.o.x, l.o.y, 0) * slant.cosine, V3d(l.d.x, l.d.y, 0) * slant.cosine,
               slant.cosine * middle - slant.sine * l.o.z, -slant.sine * l.d.z, 0);
}

/// The ball at a round cone's lower (-1) or upper (1) end.
ExactBall end_ball(const Quadric& q, int end) {
    return {V3d(0, 0, end * q.height / 2), end < 0 ? q.radius : q.radius_top};
}

Interval inside(const Quadric& q, const Line& l) {
    Interval in;
    const double h = q.height / 2;
    switch (q.kind) {
        case QuadricKind::Sphere:
            clip_ball(in, l, V3d(0), q.radius, 0);
            break;
        case QuadricKind::Cube:
            for (int a = 0; a < 3; ++a)
                clip_slab(in, l, a, q.size / 2, static_cast<std::uint8_t>(2 * a),
                          static_cast<std::uint8_t>(2 * a + 1));
            break;
        case QuadricKind::Cylinder:
            clip_slab(in, l, 2, h, 1, 2);
            clip_tube(in, l, q.radius, 0);
            break;
        case QuadricKind::Cone:
            // The slab's upper side is the apex: where rounding makes it bind, it is the side's
            // end.
            clip_slab(in, l, 2, h, 1, 0);
            clip_side(in, l, q.radius / q.height, h, 0);
            break;
        case QuadricKind::Frustum:
            clip_slab(in, l, 2, h, 1, 2);
            clip_frustum_side(in, l, q);
            break;
        case QuadricKind::RoundCone:
            return inside_round_cone(l, end_ball(q, -1), end_ball(q, 1));
        case QuadricKind::Capsule: {
            // The tube's ends lie within the balls; where rounding makes one bind, it is the ball.
            clip_slab(in, l, 2, h, 1, 2);
            clip_tube(in, l, q.radius, 0);
            Interval low, high;
            clip_ball(low, l, V3d(0, 0, -h), q.radius, 1);
            clip_ball(high, l, V3d(0, 0, h), q.radius, 2);
            in.unite(low);
            in.unite(high);
            break;
        }
        case QuadricKind::Plane:
            if (l.d.z == 0) {
                in.clear();
            } else {
                const double t = -l.o.z / l.d.z;
                if (std::fabs(l.o.x + t * l.d.x) <= q.width / 2 &&
                    std::fabs(l.o.y + t * l.d.y) <= q.length / 2)
                    in.clip(t, 0, t, 0);
                else
                    in.clear();
            }
            break;
    }
    return in;
}

bool degenerate(const Quadric& q) {
    switch (q.kind) {
        case QuadricKind::Sphere:
            return !(q.radius > 0);
        case QuadricKind::Cube:
            return !(q.size > 0);
        case QuadricKind::Cylinder:
        case QuadricKind::Cone:
            return !(q.radius > 0 && q.height > 0);
        case QuadricKind::Capsule:
            return !(q.radius > 0 && q.height >= 0);
        case QuadricKind::Plane:
            return !(q.width > 0 && q.length > 0);
        case QuadricKind::Frustum:
        case QuadricKind::RoundCone:
            return !(q.radius >= 0 && q.radius_top >= 0 && q.radius + q.radius_top > 0 &&
                     q.height > 0);
    }
    return true;
}

}  // namespace

bool judge_quadric(const Quadric& quadric, const M44d& shape_from_trace, const JudgeRay& ray,
                   SolidHit& hit) {
    if (degenerate(quadric)) return false;
    const V3d o(ray.origin[0], ray.origin[1], ray.origin[2]);
    const V3d d(ray.direction[0], ray.direction[1], ray.direction[2]);
    Line line{transform_point(shape_from_trace, o), transform_direction(shape_from_trace, d)};
    const double anchor = nearest_parameter(line.o, line.d, V3d(0));
    line.o = point_at(line.o, line.d, anchor);

    const Interval in = inside(quadric, line);
    if (in.empty()) return false;
    const double enter = anchor + in.enter, exit = anchor + in.exit;
    if (enter > 0) {
        hit = {enter, in.enter_piece};
        return enter < ray.t_max;
    }
    hit = {exit, in.exit_piece};
    return exit > 0 && exit < ray.t_max;
}

ShapePoint on_quadric(const Quadric& q, std::uint8_t piece, const V3d& point) {
    const double h = q.height / 2;
    const auto on_ball = [&](double z) {
        V3d n(point.x, point.y, point.z - z);
        const double length = n.length();
        n = length > 0 ? n / length : V3d(0, 0, 1);
        V3d p = n * q.radius;
        p.z += z;
        return ShapePoint{p, n};
    };
    const auto around = [&](double r) {  // the unit vector away from the axis, scaled
        const double length = std::sqrt(point.x * point.x + point.y * point.y);
        return length > 0 ? V2d(point.x / length * r, point.y / length * r) : V2d(r, 0);
    };
    switch (q.kind) {
        case QuadricKind::Sphere:
            return on_ball(0);
        case QuadricKind::Cube: {
            const int axis = piece / 2;
            const double side = piece % 2 == 0 ? -1 : 1;
            ShapePoint s{point, V3d(0, 0, 0)};
            s.position[axis] = side * q.size / 2;
            s.normal[axis] = side;
            return s;
        }
        case QuadricKind::Cylinder: {
            if (piece == 0) {
                const V2d p = around(q.radius), n = around(1);
                return {V3d(p.x, p.y, point.z), V3d(n.x, n.y, 0)};
            }
            const double side = piece == 1 ? -1 : 1;
            return {V3d(point.x, point.y, side * h), V3d(0, 0, side)};
        }
        case QuadricKind::Cone: {
            if (piece == 1) return {V3d(point.x, point.y, -h), V3d(0, 0, -1)};
            const double k = q.radius / q.height, w = h - point.z;
            if (!(w > 0)) return {V3d(0, 0, h), V3d(0, 0, 1)};
            const V2d p = around(k * w), n = around(1);
            return {V3d(p.x, p.y, point.z), V3d(n.x, n.y, k)};
        }
        case QuadricKind::Capsule: {
            if (piece != 0) return on_ball(piece == 1 ? -h : h);
            const V2d p = around(q.radius), n = around(1);
            return {V3d(p.x, p.y, point.z), V3d(n.x, n.y, 0)};
        }
        case QuadricKind::Frustum: {
            if (piece != 0) {
                const double side = piece == 1 ? -1 : 1;
                return {V3d(point.x, point.y, side * h), V3d(0, 0, side)};
            }
            const Slant slant(q);
            const V2d n = around(1);
            const V3d normal(slant.cosine * n.x, slant.cosine * n.y, slant.sine);
            const double above = slant.cosine * (std::sqrt(point.x * point.x + point.y * point.y) -
                                                 (q.radius + q.radius_top) / 2) +
                                 slant.sine * point.z;
            return {point - normal * above, normal};
        }
        case QuadricKind::RoundCone:
            return on_round_cone(end_ball(q, -1), end_ball(q, 1), piece, point);
        case QuadricKind::Plane:
            break;
    }
    return {V3d(point.x, point.y, 0), V3d(0, 0, 1)};
}

V3d quadric_half_extent(const Quadric& q, const M44d& m) {
    V3d half;
    for (int a = 0; a < 3; ++a) {
        const double x = std::fabs(m[0][a]), y = std::fabs(m[1][a]), z = std::fabs(m[2][a]);
        const double disk = std::sqrt(x * x + y * y);
        switch (q.kind) {
            case QuadricKind::Sphere:
                half[a] = q.radius * std::sqrt(x * x + y * y + z * z);
                break;
            case QuadricKind::Cube:
                half[a] = q.size / 2 * (x + y + z);
                break;
            case QuadricKind::Cylinder:
            case QuadricKind::Cone:
                half[a] = q.radius * disk + q.height / 2 * z;
                break;
            case QuadricKind::Frustum:
                half[a] = std::max(q.radius, q.radius_top) * disk + q.height / 2 * z;
                break;
            case QuadricKind::RoundCone:
                half[a] = std::max(q.radius, q.radius_top) * std::sqrt(x * x + y * y + z * z) +
                          q.height / 2 * z;
                break;
            case QuadricKind::Capsule:
                half[a] = q.radius * std::sqrt(x * x + y * y + z * z) + q.height / 2 * z;
                break;
            case QuadricKind::Plane:
                half[a] = q.width / 2 * x + q.length / 2 * y;
                break;
        }
    }
    return half;
}

}  // namespace irt::trace
