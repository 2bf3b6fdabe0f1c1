// SPDX-License-Identifier: Apache-2.0
// Noises as MaterialX has them (libraries/stdlib/genglsl/lib/mx_noise.glsl, which are those of Open
// Shading Language), in double: Perlin's gradient noise, and the noises of cells and of Worley over
// the hash of Bob Jenkins (lookup3).
#pragma once

#include <array>

namespace irt::graph {

using Point2 = std::array<double, 2>;
using Point3 = std::array<double, 3>;

/// From about -1 to 1; 0 at whole coordinates.
[[nodiscard]] double perlin(const Point2& p);
[[nodiscard]] double perlin(const Point3& p);
/// Three of them, by other bits of the same hash.
[[nodiscard]] std::array<double, 3> perlin_vector(const Point2& p);
[[nodiscard]] std::array<double, 3> perlin_vector(const Point3& p);

/// From 0 to 1, the same within a unit cell.
[[nodiscard]] double cells(const Point2& p);
[[nodiscard]] double cells(const Point3& p);

/// Distances to the nearest three points, one a cell, each off its cell's middle by up to half a
/// cell times `jitter`.
[[nodiscard]] std::array<double, 3> worley(const Point2& p, double jitter);
[[nodiscard]] std::array<double, 3> worley(const Point3& p, double jitter);
/// Of the cell of the nearest: three random numbers, and the one of `cells`.
[[nodiscard]] std::array<double, 4> worley_cells(const Point2& p, double jitter);
[[nodiscard]] std::array<double, 4> worley_cells(const Point3& p, double jitter);

}  // namespace irt::graph
