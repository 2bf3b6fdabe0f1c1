// SPDX-License-Identifier: Apache-2.0
// The stretch of a ray inside a convex body, from those inside slabs, tubes, balls and cones.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "irt/math/vec.h"

namespace irt::trace {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// The stretch of the ray inside a convex body; empty where enter > exit.
struct Interval {
    double enter = -infinity, exit = infinity;
    std::uint8_t enter_piece = 0, exit_piece = 0;

    [[nodiscard]] bool empty() const { return !(enter <= exit); }
    void clear() {
        enter = infinity;
        exit = -infinity;
    }
    void shift(double t) {
        enter += t;
        exit += t;
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
inline double difference_of_products(double a, double b, double c, double d) {
    const double cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

inline V3d cross_product(const V3d& a, const V3d& b) {
    return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
            difference_of_products(a.x, b.y, a.y, b.x)};
}

/// A ray as the bodies see it: in shape space, its origin moved along it near the body, lest
/// distance cancel in every square.
struct Line {
    V3d o, d;
};

/// The parameter of the point of o + t d nearest to `centre`.
inline double nearest_parameter(const V3d& o, const V3d& d, const V3d& centre) {
    return (centre - o).dot(d) / d.dot(d);
}
inline V3d point_at(const V3d& o, const V3d& d, double t) {
    return {std::fma(t, d.x, o.x), std::fma(t, d.y, o.y), std::fma(t, d.z, o.z)};
}

/// -h <= z <= +h along `axis`.
inline void clip_slab(Interval& in, const Line& l, int axis, double h, std::uint8_t low,
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
inline void clip_tube(Interval& in, const Line& l, double r, std::uint8_t piece) {
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

/// The ball of radius r about `centre`.
inline void clip_ball(Interval& in, const Line& l, const V3d& centre, double r,
                      std::uint8_t piece) {
    const V3d o = l.o - centre;
    const double a = l.d.dot(l.d);
    const V3d cross = cross_product(o, l.d);
    const double distance = std::sqrt(cross.dot(cross)), scaled = r * std::sqrt(a);
    const double discriminant = (scaled - distance) * (scaled + distance);
    if (!(discriminant >= 0)) return in.clear();
    const auto [middle, half] = divided(-o.dot(l.d), std::sqrt(discriminant), a);
    in.clip(middle - half, piece, middle + half, piece);
}

/// |p| <= w, p and w being the linear functions p + t dp and w + t dw of the ray's parameter, w >=
/// 0: one nappe of a cone without its base, or for dw = 0 a tube.
inline void clip_nappe(Interval& in, const V3d& p, const V3d& dp, double w, double dw,
                       std::uint8_t piece) {
    const double slope = std::sqrt(dp.dot(dp));
    const double a = (slope - dw) * (slope + dw);
    const double b = p.dot(dp) - w * dw;
    // b^2 - a c, written in differences that stay small near the surface (Lagrange's identity):
    // |p|^2 dw^2 + |dp|^2 w^2 - 2 (p.dp) w dw - (p x dp)^2 = |w dp - dw p|^2 - (p x dp)^2.
    const V3d along(difference_of_products(w, dp.x, dw, p.x),
                    difference_of_products(w, dp.y, dw, p.y),
                    difference_of_products(w, dp.z, dw, p.z));
    const V3d across = cross_product(p, dp);
    const double e = std::sqrt(along.dot(along)), f = std::sqrt(across.dot(across));
    double discriminant = (e - f) * (e + f);
    const double distance = std::sqrt(p.dot(p)), c = (distance - w) * (distance + w);
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

}  // namespace irt::trace
