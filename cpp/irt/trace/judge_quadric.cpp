// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/judge_quadric.h"

#include <cmath>
#include <limits>
#include <utility>

namespace irt::trace {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The stretch of the ray inside a convex body; empty where enter > exit.
struct Interval {
    double enter = -infinity, exit = infinity;
    std::uint8_t enter_piece = 0, exit_piece = 0;

    [[nodiscard]] bool empty() const { return !(enter <= exit); }
    void clear() {
        enter = infinity;
        exit = -infinity;
    }
    void clip(double lo, std::uint8_t lo_piece, double hi, std::uint8_t hi_piece) {
        if (!(lo <= hi)) return clear();
        if (lo > enter) enter = lo, enter_piece = lo_piece;
        if (hi < exit) exit = hi, exit_piece = hi_piece;
    }
    void unite(const Interval& o) {
        if (o.empty()) return;
        if (empty()) {
            *this = o;
            return;
        }
        if (o.enter < enter) enter = o.enter, enter_piece = o.enter_piece;
        if (o.exit > exit) exit = o.exit, exit_piece = o.exit_piece;
    }
};

/// a b - c d within 1.5 ulp (Kahan; Jeannerod, Louvet, Muller, Math. Comp. 82, 2013).
double difference_of_products(double a, double b, double c, double d) {
    const double cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

struct Line {
    V3d o, d;  ///< shape space, o being the point nearest to the shape's origin
};

/// -h <= z <= +h along `axis`.
void clip_slab(Interval& in, const Line& l, int axis, double h, std::uint8_t low,
               std::uint8_t high) {
    const double o = l.o[axis], d = l.d[axis];
    if (d == 0) {
        if (!(std::fabs(o) <= h)) in.clear();
        return;
    }
    const auto [a, b] = divided(-h - o, h - o, d);
    if (d > 0)
        in.clip(a, low, b, high);
    else
        in.clip(b, high, a, low);
}

/// x^2 + y^2 <= r^2. The discriminant is the cross product's, free of the distance to the axis.
void clip_tube(Interval& in, const Line& l, double r, std::uint8_t piece) {
    const double a = l.d.x * l.d.x + l.d.y * l.d.y;
    if (a == 0) {
        if (!(l.o.x * l.o.x + l.o.y * l.o.y <= r * r)) in.clear();
        return;
    }
    const double cross = difference_of_products(l.o.x, l.d.y, l.o.y, l.d.x);
    const double scaled = r * std::sqrt(a);
    const double discriminant = (scaled - cross) * (scaled + cross);
    if (!(discriminant >= 0)) return in.clear();
    const auto [middle, half] =
        divided(-(l.o.x * l.d.x + l.o.y * l.d.y), std::sqrt(discriminant), a);
    in.clip(middle - half, piece, middle + half, piece);
}

/// The ball of radius r about (0, 0, z).
void clip_ball(Interval& in, const Line& l, double z, double r, std::uint8_t piece) {
    const V3d o(l.o.x, l.o.y, l.o.z - z);
    const double a = l.d.dot(l.d);
    const V3d cross(difference_of_products(o.y, l.d.z, o.z, l.d.y),
                    difference_of_products(o.z, l.d.x, o.x, l.d.z),
                    difference_of_products(o.x, l.d.y, o.y, l.d.x));
    const double distance = std::sqrt(cross.dot(cross)), scaled = r * std::sqrt(a);
    const double discriminant = (scaled - distance) * (scaled + distance);
    if (!(discriminant >= 0)) return in.clear();
    const auto [middle, half] = divided(-o.dot(l.d), std::sqrt(discriminant), a);
    in.clip(middle - half, piece, middle + half, piece);
}

/// x^2 + y^2 <= (k w)^2 with w = apex - z >= 0: one nappe, without its base.
void clip_nappe(Interval& in, const Line& l, double apex, double k, std::uint8_t piece) {
    const double w = k * (apex - l.o.z), dw = -k * l.d.z;
    const double flat = l.d.x * l.d.x + l.d.y * l.d.y;
    const double slope = std::sqrt(flat);
    const double a = (slope - dw) * (slope + dw);
    const double b = l.o.x * l.d.x + l.o.y * l.d.y - w * dw;
    // b^2 - a c, written in differences that stay small near the surface (Lagrange's identity):
    // |o|^2 dw^2 + |d|^2 w^2 - 2 (o.d) w dw - (o x d)^2 = |w d - dw o|^2 - (o x d)^2.
    const double ex = difference_of_products(w, l.d.x, dw, l.o.x),
                 ey = difference_of_products(w, l.d.y, dw, l.o.y);
    const double cross = difference_of_products(l.o.x, l.d.y, l.o.y, l.d.x);
    const double e = std::sqrt(ex * ex + ey * ey), f = std::fabs(cross);
    double discriminant = (e - f) * (e + f);
    const double c = difference_of_products(l.o.x, l.o.x, w, w) + l.o.y * l.o.y;
    if (a > 0) {
        if (!(discriminant >= 0)) return in.clear();
    } else if (!(discriminant > 0)) {
        discriminant = 0;  // steeper than the side: the line meets it always, at worst in the apex
    }
    const double root = std::sqrt(discriminant);
    const double q = b < 0 ? root - b : -(root + b);
    if (q == 0) {  // b = root = 0: along the side through the apex, or touching the apex alone
        if (a > 0) return in.clip(0, piece, 0, piece);
        if (a == 0) {
            if (c > 0) in.clear();
            return;
        }
        if (dw > 0) return in.clip(0, piece, infinity, piece);
        return in.clip(-infinity, piece, 0, piece);
    }
    const double t0 = a == 0 ? (q > 0 ? infinity : -infinity) : q / a, t1 = c / q;
    const double lo = t0 < t1 ? t0 : t1, hi = t0 < t1 ? t1 : t0;
    if (a > 0) return in.clip(lo, piece, hi, piece);
    if (a == 0) {  // parallel to a generator: inside beyond the one root, where w grows
        if (b < 0) return in.clip(t1, piece, infinity, piece);
        return in.clip(-infinity, piece, t1, piece);
    }
    // Inside beyond each root, once a nappe; ours is where w is positive.
    if (dw > 0) return in.clip(hi, piece, infinity, piece);
    return in.clip(-infinity, piece, lo, piece);
}

Interval inside(const Quadric& q, const Line& l) {
    Interval in;
    const double h = q.height / 2;
    switch (q.kind) {
        case QuadricKind::Sphere:
            clip_ball(in, l, 0, q.radius, 0);
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
            clip_nappe(in, l, h, q.radius / q.height, 0);
            break;
        case QuadricKind::Capsule: {
            // The tube's ends lie within the balls; where rounding makes one bind, it is the ball.
            clip_slab(in, l, 2, h, 1, 2);
            clip_tube(in, l, q.radius, 0);
            Interval low, high;
            clip_ball(low, l, -h, q.radius, 1);
            clip_ball(high, l, h, q.radius, 2);
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
    }
    return true;
}

}  // namespace

bool judge_quadric(const Quadric& quadric, const M44d& shape_from_trace, const JudgeRay& ray,
                   QuadricHit& hit) {
    if (degenerate(quadric)) return false;
    const V3d o(ray.origin[0], ray.origin[1], ray.origin[2]);
    const V3d d(ray.direction[0], ray.direction[1], ray.direction[2]);
    Line line{transform_point(shape_from_trace, o), transform_direction(shape_from_trace, d)};
    // From the point nearest to the shape's origin: distance then cancels once, not in every
    // square.
    const double anchor = -line.o.dot(line.d) / line.d.dot(line.d);
    for (int a = 0; a < 3; ++a) line.o[a] = std::fma(anchor, line.d[a], line.o[a]);

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
