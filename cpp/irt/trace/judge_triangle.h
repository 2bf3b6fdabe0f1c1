// SPDX-License-Identifier: Apache-2.0
// Ray against triangle, decided exactly: once alone, once eight at a time with equal bits.
//
// The triangle is seen along the ray (Woop, Benthin, Wald, JCGT 2(1), 2013): each vertex becomes a
// 2D point that depends on the vertex and the ray alone, so triangles that share a vertex share the
// point. Whether the ray passes inside is then a question about three signs, and each sign is
// exact: of two rounded products that differ, the greater belongs to the greater product (rounding
// is monotonic); of equal ones the rounding errors, had exactly by fma, decide; and where the
// products are truly equal the origin is moved by (e, e^2), e infinitely small ("Simulation of
// Simplicity", Edelsbrunner and Muecke, 1990). So a ray meets a closed mesh an even number of
// times, whatever it is aimed at, and a ray through a shared edge or vertex belongs to exactly one
// triangle a sheet.
#pragma once

#include <immintrin.h>

#include <cstdint>

#include "irt/trace/judge_ray.h"

namespace irt::trace {

/// Up to four pairs of triangles that share an edge, axis by axis: a lane holds (0, 1, 2) and
/// (0, 2, 3) of its four vertices, so that eight triangles read less memory than six alone would.
/// Absent vertices are NaN, which no test accepts.
struct alignas(32) TrianglePacket {
    float vertex[4][3][4];          ///< [vertex of the pair][axis][lane]
    std::uint32_t primitive[2][4];  ///< [side][lane]: triangle of the mesh and turn; or `none`

    /// Vertex k of the mesh's triangle is corner (k + turn) % 3 here; its index takes 30 bits.
    static constexpr std::uint32_t turn_shift = 30, index_mask = (1u << turn_shift) - 1;
    /// Vertices of the pair's triangle `side`.
    static constexpr int corner[2][3] = {{0, 1, 2}, {0, 2, 3}};

    [[nodiscard]] std::uint32_t triangle(int side, int lane) const {
        return primitive[side][lane] & index_mask;
    }
    [[nodiscard]] int turn(int side, int lane) const {
        return static_cast<int>(primitive[side][lane] >> turn_shift);
    }
    [[nodiscard]] V3f point(int v, int lane) const {
        return {vertex[v][0][lane], vertex[v][1][lane], vertex[v][2][lane]};
    }
};
static_assert(sizeof(TrianglePacket) == 224);

struct TriangleHit {
    double t;
    double u, v;  ///< weights of the second and the third vertex
    bool front;   ///< met counter-clockwise
};

namespace detail {

/// Twice the signed area of (0, a, b): never zero in sign, unless a equals b.
struct Edge {
    double value;
    int sign;
};

inline Edge edge(double ax, double ay, double bx, double by) {
    const double p = ax * by, q = ay * bx;
    if (p != q) return {p - q, p > q ? 1 : -1};
    const double p_error = std::fma(ax, by, -p), q_error = std::fma(ay, bx, -q);
    if (p_error != q_error) return {p_error - q_error, p_error > q_error ? 1 : -1};
    if (ay != by) return {0, ay > by ? 1 : -1};
    return {0, bx > ax ? 1 : (bx < ax ? -1 : 0)};
}

/// The rest of the judgement, once the ray is known to pass inside: weights `a`, `b`, `c` of one
/// sign, depths along kz. `t` is a convex combination, hence never beyond the triangle's own
/// depths.
inline TriangleHit finish(double a, double b, double c, double az, double bz, double cz, double sz,
                          bool front) {
    const double inverse = 1 / ((a + b) + c);
    const double depth = ((a * az + b * bz) + c * cz) * inverse;
    return {depth * sz, b * inverse, c * inverse, front};
}

}  // namespace detail

/// Judges one triangle; true where the ray's line passes inside it, `hit.t` then being any number.
/// The reference of judge_packet.
inline bool judge_triangle(const V3f& a, const V3f& b, const V3f& c, const JudgeRay& ray,
                           TriangleHit& hit) {
    const int kx = ray.kx, ky = ray.ky, kz = ray.kz;
    const auto along = [&](const V3f& p, int axis) {
        return static_cast<double>(p[axis]) - ray.origin[axis];
    };
    const double az = along(a, kz), bz = along(b, kz), cz = along(c, kz);
    const double ax = std::fma(-ray.sx, az, along(a, kx)), ay = std::fma(-ray.sy, az, along(a, ky));
    const double bx = std::fma(-ray.sx, bz, along(b, kx)), by = std::fma(-ray.sy, bz, along(b, ky));
    const double cx = std::fma(-ray.sx, cz, along(c, kx)), cy = std::fma(-ray.sy, cz, along(c, ky));
    const detail::Edge u = detail::edge(cx, cy, bx, by), v = detail::edge(ax, ay, cx, cy),
                       w = detail::edge(bx, by, ax, ay);
    if (u.sign == 0 || u.sign != v.sign || u.sign != w.sign) return false;
    hit = detail::finish(u.value, v.value, w.value, az, bz, cz, ray.sz, u.sign > 0);
    return hit.t == hit.t;  // NaN only where every weight underflowed
}

/// What judge_packet found. Bits are 4 * side + lane.
struct PacketHits {
    unsigned inside;                     ///< triangles whose inside the ray passes
    unsigned alone;                      ///< triangles that only judge_triangle can decide
    alignas(32) double depth[4][4];      ///< [vertex of the pair][lane]
    alignas(32) double weight[2][3][4];  ///< [side][corner][lane]
};

/// Judges the eight triangles of a packet; false if the ray passes inside none.
inline bool judge_packet(const TrianglePacket& packet, const JudgeRay& ray, PacketHits& hits) {
    const __m256d ox = _mm256_set1_pd(ray.origin[ray.kx]), oy = _mm256_set1_pd(ray.origin[ray.ky]),
                  oz = _mm256_set1_pd(ray.origin[ray.kz]);
    const __m256d sx = _mm256_set1_pd(ray.sx), sy = _mm256_set1_pd(ray.sy);
    __m256d x[4], y[4], z[4];
    for (int v = 0; v < 4; ++v) {
        const auto along = [&](int axis, __m256d origin) {
            return _mm256_sub_pd(_mm256_cvtps_pd(_mm_load_ps(packet.vertex[v][axis])), origin);
        };
        z[v] = along(ray.kz, oz);
        x[v] = _mm256_fnmadd_pd(sx, z[v], along(ray.kx, ox));
        y[v] = _mm256_fnmadd_pd(sy, z[v], along(ray.ky, oy));
    }
    const auto edge = [&](int a, int b) {
        return _mm256_sub_pd(_mm256_mul_pd(x[a], y[b]), _mm256_mul_pd(y[a], x[b]));
    };
    // The shared edge, walked the other way by the second triangle, has exactly the other sign.
    const __m256d e21 = edge(2, 1), e02 = edge(0, 2), e10 = edge(1, 0), e32 = edge(3, 2),
                  e03 = edge(0, 3);
    const __m256d zero = _mm256_setzero_pd();
    const auto above = [&](__m256d e) { return _mm256_cmp_pd(e, zero, _CMP_GT_OQ); };
    const auto below = [&](__m256d e) { return _mm256_cmp_pd(e, zero, _CMP_LT_OQ); };
    const auto equal = [&](__m256d e) { return _mm256_cmp_pd(e, zero, _CMP_EQ_OQ); };
    const auto all = [](__m256d a, __m256d b, __m256d c) {
        return _mm256_and_pd(_mm256_and_pd(a, b), c);
    };
    const auto any = [](__m256d a, __m256d b, __m256d c) {
        return _mm256_or_pd(_mm256_or_pd(a, b), c);
    };
    const auto bits = [](__m256d first, __m256d second) {
        return static_cast<unsigned>(_mm256_movemask_pd(first)) |
               static_cast<unsigned>(_mm256_movemask_pd(second)) << 4;
    };
    const __m256d shared_above = above(e02), shared_below = below(e02), shared_equal = equal(e02);
    hits.inside = bits(_mm256_or_pd(all(above(e21), above(e10), shared_above),
                                    all(below(e21), below(e10), shared_below)),
                       _mm256_or_pd(all(above(e32), above(e03), shared_below),
                                    all(below(e32), below(e03), shared_above)));
    hits.alone =
        bits(any(equal(e21), equal(e10), shared_equal), any(equal(e32), equal(e03), shared_equal));
    if ((hits.inside | hits.alone) == 0) return false;
    for (int v = 0; v < 4; ++v) _mm256_store_pd(hits.depth[v], z[v]);
    _mm256_store_pd(hits.weight[0][0], e21);
    _mm256_store_pd(hits.weight[0][1], e02);
    _mm256_store_pd(hits.weight[0][2], e10);
    _mm256_store_pd(hits.weight[1][0], e32);
    _mm256_store_pd(hits.weight[1][1], e03);
    _mm256_store_pd(hits.weight[1][2], _mm256_sub_pd(zero, e02));
    return true;
}

/// Finishes the triangle of one bit of inside | alone, with the bits judge_triangle has.
inline bool finish_lane(const TrianglePacket& packet, const JudgeRay& ray, const PacketHits& hits,
                        int side, int lane, TriangleHit& hit) {
    static constexpr int turned[] = {0, 1, 2, 0, 1};
    const int turn = packet.turn(side, lane);
    const auto corner = [&](int k) { return turned[turn + k]; };
    if ((hits.alone >> (4 * side + lane) & 1) != 0) {
        const auto point = [&](int k) {
            return packet.point(TrianglePacket::corner[side][corner(k)], lane);
        };
        return judge_triangle(point(0), point(1), point(2), ray, hit);
    }
    const auto weight = [&](int k) { return hits.weight[side][corner(k)][lane]; };
    const auto depth = [&](int k) {
        return hits.depth[TrianglePacket::corner[side][corner(k)]][lane];
    };
    hit = detail::finish(weight(0), weight(1), weight(2), depth(0), depth(1), depth(2), ray.sz,
                         weight(0) > 0);
    return hit.t == hit.t;
}

}  // namespace irt::trace
