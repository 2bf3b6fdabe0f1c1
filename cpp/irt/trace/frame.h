// SPDX-License-Identifier: Apache-2.0
// How a double ray becomes the float ray of one Embree tree, and how wide boxes must then be for
// what Embree proposes to hold everything the judges would accept.
#pragma once

#include <immintrin.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "irt/mutant.h"
#include "irt/trace/judge_ray.h"
#include "irt/trace/packets.h"

namespace irt::trace {

/// Pad of a tree's boxes, in units of its `half`: 16 * 2^-24.
///
/// Embree walks user geometry with its fast box test whatever the scene's flags say (3.13.5,
/// bvh_intersector1_bvh8.cpp: BVH8VirtualIntersector1 has robust = false): t = box * r - origin * r
/// with r an approximate reciprocal. With u = 2^-24, on each axis:
///   origin * r is rounded before the fused subtraction              u |origin|      <=  1 u half
///   r is within 3.5 u (rcpps, one Newton step), t rounded by u    5 u |box - origin| <= 10 u half
///   the origin is narrowed to float                                 u |origin|      <=  1 u half
///   the direction is narrowed to float (inside instances)           u |box - origin| <= 2 u half
/// where the origin lies within `half` of the centre (anchor() sees to it) and so does the box. The
/// remaining 2 u half cover the judges' own rounding in double: that of rays which start up to 10^8
/// halves away.
inline constexpr double box_pad = 16.0 / (1 << 24);

/// Of t, how far Embree's search goes on behind the best hit. Boxes padded as above are entered
/// before what they hold, so this need cover only the rounding of the limit itself; it has room.
inline constexpr double search_slack = 1e-4;

/// The space of one tree: the trace space, counted from `centre`.
struct Frame {
    V3d centre{0, 0, 0};
    double half = 0;  ///< everything in the tree lies within this of the centre, on each axis
    Box box;          ///< trace space, of everything in the tree, padded

    [[nodiscard]] double pad() const { return mutated(Mutant::no_box_pad) ? 0 : box_pad * half; }
};

/// The ray handed to Embree: t there is (t - start) * scale. Each three numbers are followed by the
/// zero that Embree keeps behind them (tnear, time), so that four are written and read at once.
struct EmbreeRay {
    __m128 origin, direction;
    double start = 0, scale = 1;

    /// Embree's limit for a search that has to find everything up to `t`.
    [[nodiscard]] float limit(double t) const {
        if (mutated(Mutant::search_ends_short) && t < 1e300) t -= 2 * t * search_slack;
        return static_cast<float>((t + t * search_slack - start) * scale) +
               std::numeric_limits<float>::min();
    }
};

/// Brings `ray` (trace space of `frame`) to where it enters the frame's box, its largest direction
/// component to [1, 2) by a power of two (Embree drops the sign of components below 1e-18), and
/// narrows it. False if it misses the box, or enters it beyond `t_limit`.
inline bool anchor(const Frame& frame, const JudgeRay& ray, double t_limit, EmbreeRay& out) {
    double enter = 0, exit = t_limit;
    for (int a = 0; a < 3; ++a) {
        const double d = ray.direction[a], o = ray.origin[a];
        if (d == 0) {
            if (frame.box.lower[a] > o || frame.box.upper[a] < o) return false;
            continue;
        }
        // Addresses are chosen, not values: that costs no branch, which signs would mispredict.
        const V3d* const sides[] = {&frame.box.upper, &frame.box.lower};
        const int forward = d > 0 ? 1 : 0;
        const double inverse = 1 / d;
        enter = std::max(enter, ((*sides[forward])[a] - o) * inverse);
        exit = std::min(exit, ((*sides[1 - forward])[a] - o) * inverse);
    }
    if (!(enter <= exit)) return false;
    constexpr std::uint64_t exponent = 0x7ff0000000000000u;
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(ray.direction[ray.kz]) & exponent;
    if (bits == 0 || bits == exponent) return false;  // no direction that a judge would accept
    out.scale = std::bit_cast<double>(bits);
    out.start = enter;
    const double unscale = 1 / out.scale;
    const auto origin = [&](int a) {
        return static_cast<float>(
            std::fma(enter, ray.direction[a], ray.origin[a] - frame.centre[a]));
    };
    const auto direction = [&](int a) {
        const double d = ray.direction[a] * unscale;
        constexpr auto least = static_cast<double>(direction_nudge);
        return static_cast<float>(std::fabs(d) < least ? std::copysign(least, d) : d);
    };
    out.origin = _mm_set_ps(0, origin(2), origin(1), origin(0));
    out.direction = _mm_set_ps(0, direction(2), direction(1), direction(0));
    return true;
}

}  // namespace irt::trace
