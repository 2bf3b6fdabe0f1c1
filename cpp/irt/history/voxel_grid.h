// SPDX-License-Identifier: Apache-2.0
// The voxels in which rays and changed objects meet (paper, sections 2.2 and 2.3).
#pragma once

#include <cstdint>
#include <vector>

#include "irt/math/vec.h"
#include "irt/trace/box.h"

namespace irt::history {

/// Voxels along each axis. Coarse, so that many rays share a path; what the table leaves undecided
/// the test of the segment itself settles (DESIGN 4, step 2).
inline constexpr std::uint32_t grid_side = 16;

/// A path: the voxels a segment begins and ends in, which stand for the convex hull of the two, and
/// whether it leaves the grid. In place of the paper's set of passed voxels: nothing to walk, and a
/// superset of it.
using Path = std::uint32_t;
inline constexpr Path path_nowhere = 1u << 25;  ///< wholly outside the grid
inline constexpr Path path_outside = 1u << 24;  ///< leaves the grid, or enters it
inline constexpr std::uint32_t voxel_bits = 12;

/// The box of all but the giants among `boxes`: a ground plane must not make the voxels coarse.
/// Giants are those more than `giant` times as long as the median.
inline constexpr double giant = 8;
[[nodiscard]] trace::Box crowded_box(std::vector<trace::Box> boxes);

/// A uniform grid over a box of render space.
class VoxelGrid {
  public:
    /// Hulls are dilated by this share of a voxel on every side: hits, secondary origins and the
    /// arithmetic here err by less than 2^-20 of the grid, which is 2^-16 of a voxel (DESIGN 3,
    /// rule 8).
    static constexpr double dilation = 0x1p-6;

    VoxelGrid() = default;
    explicit VoxelGrid(const trace::Box& scene);

    /// The path of origin + t direction for t from 0 to `t_end`, which may be infinite.
    [[nodiscard]] Path path(const V3f& origin, const V3f& direction, double t_end) const;

    /// Whether a segment of this path may meet `box`.
    [[nodiscard]] bool may_meet(Path path, const trace::Box& box) const;

  private:
    [[nodiscard]] std::uint32_t voxel_at(const V3d& p) const;
    [[nodiscard]] V3d centre_of(std::uint32_t voxel) const;

    trace::Box box_;
    V3d voxel_{1, 1, 1}, per_unit_{1, 1, 1};
};

}  // namespace irt::history
