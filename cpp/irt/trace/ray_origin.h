// SPDX-License-Identifier: Apache-2.0
// Where a ray that leaves a surface starts.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "irt/trace/intersector.h"

namespace irt::trace {

/// `f`, moved by `steps` (-1, 0 or 1) to its neighbour among the floats, as std::nextafter moves
/// it. Without branches: which way a coordinate was rounded is a toss-up that no processor
/// foresees.
[[nodiscard]] inline float stepped(float f, int steps) {
    if (f == 0 && steps != 0)
        return static_cast<float>(steps) * std::numeric_limits<float>::denorm_min();
    const auto bits = std::bit_cast<std::int32_t>(f);  // counts away from zero on either side
    return std::bit_cast<float>(bits + (bits < 0 ? -steps : steps));
}

/// The float position nearest `point` from which a ray along `direction` cannot meet the primitive
/// it leaves from the wrong side: `point.position`, moved along the geometric normal to the side
/// `direction` points to, by the rounding of the position itself and of its narrowing to float,
/// each coordinate then rounded away from the surface. After OffsetRayOrigin of pbrt-v4 (Pharr,
/// Jakob, Humphreys, "Physically Based Rendering", 4th ed., 6.8.6).
[[nodiscard]] inline V3f offset_ray_origin(const SurfacePoint& point, const V3d& direction) {
    const V3d& n = point.geometric_normal;
    const double side = direction.dot(n) < 0 ? -1 : 1;
    constexpr double narrowing = 0x1p-24;
    double distance = 0;
    for (int a = 0; a < 3; ++a)
        distance += std::fabs(n[a]) * (point.error + narrowing * std::fabs(point.position[a]));
    V3f origin;
    for (int a = 0; a < 3; ++a) {
        const double away = side * n[a], p = point.position[a] + away * distance;
        const auto f = static_cast<float>(p);
        const auto narrowed = static_cast<double>(f);
        const int up = static_cast<int>(away > 0) & static_cast<int>(narrowed < p),
                  down = static_cast<int>(away < 0) & static_cast<int>(narrowed > p);
        origin[a] = stepped(f, up - down);
    }
    return origin;
}

}  // namespace irt::trace
