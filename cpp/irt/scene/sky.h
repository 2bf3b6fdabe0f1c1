// SPDX-License-Identifier: Apache-2.0
// What surrounds a scene, as rays see it, and as the distant lights that surfaces are lit by.
#pragma once

#include <vector>

#include "irt/scene/records.h"

namespace irt {

/// What `sky` shows in `direction` (world orientation, any length), filtered over a cone of angle
/// `spread` (radians; 0: unfiltered). A pure function of the three.
V3d seen_in(const Sky& sky, const V3d& direction, double spread);

/// Unit directions in which light travels, spread evenly over the sphere (Fibonacci's lattice, its
/// axis along the unit vector `up`). Throws std::invalid_argument where `count` is below 1.
std::vector<V3d> sky_directions(int count, const V3d& up);

/// A lat-long picture summed up in cells small enough to be taken for directions.
class SkyCells {
  public:
    explicit SkyCells(const Texture& texture);

    /// The irradiance at normal incidence of the distant light in each of `directions` (unit): each
    /// stands for the part of the sky that is nearest to it. `x`, `y`, `z`: the axes of the sky.
    /// Light that the picture takes away counts as none.
    [[nodiscard]] std::vector<V3d> irradiances(const V3d& x, const V3d& y, const V3d& z,
                                               const std::vector<V3d>& directions) const;

  private:
    int rows_, columns_;
    std::vector<V3d> cells_;  ///< radiance times solid angle, row by row
};

}  // namespace irt
