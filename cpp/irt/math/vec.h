// SPDX-License-Identifier: Apache-2.0
// The vector and matrix types of the core. Vectors are rows: a point is transformed as `p * m`,
// as in Imath and USD, and a matrix named `a_from_b` takes points of space b to space a.
#pragma once

#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>
#include <immintrin.h>

#include <cmath>

namespace irt {

using V2d = Imath::V2d;
using V2f = Imath::V2f;
using V3f = Imath::V3f;
using V3d = Imath::V3d;
using M44d = Imath::M44d;

/// The direction `v` (not a point: no translation) under the affine matrix `m`.
inline V3d transform_direction(const M44d& m, const V3d& v) {
    return {v.x * m[0][0] + v.y * m[1][0] + v.z * m[2][0],
            v.x * m[0][1] + v.y * m[1][1] + v.z * m[2][1],
            v.x * m[0][2] + v.y * m[1][2] + v.z * m[2][2]};
}

/// The point `p` under the affine matrix `m`; no division by w.
inline V3d transform_point(const M44d& m, const V3d& p) {
    return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
            p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
            p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}

/// A normal of space b taken to space a, where `b_from_a` is the inverse of the point transform.
inline V3d transform_normal(const M44d& b_from_a, const V3d& n) {
    return {n.x * b_from_a[0][0] + n.y * b_from_a[0][1] + n.z * b_from_a[0][2],
            n.x * b_from_a[1][0] + n.y * b_from_a[1][1] + n.z * b_from_a[1][2],
            n.x * b_from_a[2][0] + n.y * b_from_a[2][1] + n.z * b_from_a[2][2]};
}

/// v / s: the three quotients that scalar division gives, in the time of one.
inline V3d divided(const V3d& v, double s) {
    alignas(32) double quotients[4];
    _mm256_store_pd(quotients, _mm256_div_pd(_mm256_set_pd(1, v.z, v.y, v.x), _mm256_set1_pd(s)));
    return {quotients[0], quotients[1], quotients[2]};
}

/// a / s and b / s, likewise.
struct Quotients {
    double a, b;
};
inline Quotients divided(double a, double b, double s) {
    const __m128d q = _mm_div_pd(_mm_set_pd(b, a), _mm_set1_pd(s));
    return {_mm_cvtsd_f64(q), _mm_cvtsd_f64(_mm_unpackhi_pd(q, q))};
}

/// `v` at unit length. Its square must neither vanish nor overflow.
inline V3d normalized(const V3d& v) { return divided(v, std::sqrt(v.dot(v))); }

}  // namespace irt
