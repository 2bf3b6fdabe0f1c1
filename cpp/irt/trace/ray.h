// SPDX-License-Identifier: Apache-2.0
// Rays and what a query over them answers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "irt/math/vec.h"

namespace irt::trace {

/// A ray in render space; `t` counts multiples of `direction`, which need not be of unit length.
/// Valid hits have 0 < t < t_max. Made by `make_ray` alone, so that no direction component is zero
/// (DESIGN 3, rule 1: a zero component lets a slab test miss a box whose face holds the origin).
struct Ray {
    V3f origin;
    V3f direction;
    float t_max = std::numeric_limits<float>::infinity();
    /// It comes straight from the camera: what the pass hides from that is not there for it.
    bool camera = false;
};

/// Smallest direction component, relative to the largest. Far below the rounding of the largest
/// (2^-24), so that no picture can tell; far above the denormals for any direction in use.
inline constexpr float direction_nudge = 1e-15f;

inline Ray make_ray(const V3f& origin, const V3f& direction,
                    float t_max = std::numeric_limits<float>::infinity()) {
    const float least = direction_nudge * std::max({std::fabs(direction.x), std::fabs(direction.y),
                                                    std::fabs(direction.z)});
    const auto nudged = [least](float d) {
        return std::fabs(d) < least ? std::copysign(least, d) : d;
    };
    return {origin, {nudged(direction.x), nudged(direction.y), nudged(direction.z)}, t_max};
}

inline constexpr std::uint32_t none = 0xffffffffu;

/// A judged hit. `object` is a slot of the scene, `part` a part of its prototype (0 where the
/// object is no instance), `primitive` a triangle, ball or segment (0 for a quadric).
struct Hit {
    double t = std::numeric_limits<double>::infinity();
    /// Triangles: weights of the second and the third vertex. Segments: u along the axis, 0 to 1.
    double u = 0, v = 0;
    std::uint32_t object = none, part = 0, primitive = 0;
    std::uint8_t piece = 0;  ///< solids: which surface of it (see judge_quadric.h, round_cone.h)

    explicit operator bool() const { return object != none; }
};

/// Optical depth of one occluder or of a whole shadow ray, per channel: the integer
/// round(-depth_scale * log2(transmittance)). Integers add in any order (DESIGN 3, rule 4).
struct OpticalDepth {
    std::uint32_t rgb[3] = {0, 0, 0};
    bool operator==(const OpticalDepth& o) const {
        return rgb[0] == o.rgb[0] && rgb[1] == o.rgb[1] && rgb[2] == o.rgb[2];
    }
};
inline constexpr double depth_scale = 4096;              ///< steps an octave: 0.017 % a step
inline constexpr std::uint32_t depth_opaque = 1u << 20;  ///< 256 octaves: nothing passes

/// What a shadow ray met. A channel at or above depth_opaque is black, and is then stored as
/// depth_opaque exactly. `blocker` names an occluder opaque in all channels, or is `none`; which
/// one of several it names may depend on the tree and must never reach a value.
struct Occlusion {
    OpticalDepth depth;
    std::uint32_t blocker = none;
};

/// Counts of one thread's queries. `candidates` are judged primitives (the paper's intersections).
struct QueryCounts {
    std::uint64_t nearest = 0, occlusion = 0, candidates = 0;
};

}  // namespace irt::trace
