// SPDX-License-Identifier: Apache-2.0
// The voxels in which rays and changed objects meet (paper, sections 2.2 and 2.3).
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <string>
#include <vector>

#include "irt/math/vec.h"
#include "irt/mutant.h"
#include "irt/trace/box.h"

namespace irt::history {

/// Voxels along each axis. Coarse, so that many rays share a path; what the table leaves undecided
/// the test of the segment itself settles (DESIGN 4, step 2; docs/measurements.md, "Grid").
inline constexpr std::uint32_t grid_side = 32;
inline constexpr std::uint32_t voxel_count = grid_side * grid_side * grid_side;

/// A path: the voxels a segment begins and ends in, which stand for the convex hull of the two, and
/// whether it leaves the grid. In place of the paper's set of passed voxels: nothing to walk, and a
/// superset of it.
using Path = std::uint32_t;
inline constexpr std::uint32_t voxel_bits = 15;
inline constexpr Path path_outside = 1u << 30;  ///< leaves the grid, or enters it
inline constexpr Path path_nowhere = 1u << 31;  ///< wholly outside the grid

/// Column, row and layer of a voxel.
using Voxel = std::array<std::int32_t, 3>;

/// The box of all but the giants among `boxes`: a ground plane must not make the voxels coarse.
/// Giants are those more than `giant` times as long as the median.
inline constexpr double giant = 8;
[[nodiscard]] trace::Box crowded_box(std::vector<trace::Box> boxes);

/// A set of voxels, and whether it goes on outside the grid: where changed objects are (the change
/// flags on voxels of section 2.2).
class VoxelSet {
  public:
    void add(const Voxel& voxel) {
        voxels_.set(index(voxel));
        for (std::size_t a = 0; a < 3; ++a) {
            lower_[a] = std::min(lower_[a], voxel[a]);
            upper_[a] = std::max(upper_[a], voxel[a] + 1);
        }
    }
    void add_outside() { outside_ = !mutated(Mutant::outside_ignored); }
    [[nodiscard]] bool has(const Voxel& voxel) const { return voxels_.test(index(voxel)); }
    [[nodiscard]] bool outside() const { return outside_; }
    /// Its voxels are within [lower, upper) on each axis.
    [[nodiscard]] const Voxel& lower() const { return lower_; }
    [[nodiscard]] const Voxel& upper() const { return upper_; }

  private:
    static std::size_t index(const Voxel& v) {
        return (static_cast<std::size_t>(v[2]) * grid_side + static_cast<std::size_t>(v[1])) *
                   grid_side +
               static_cast<std::size_t>(v[0]);
    }

    std::bitset<voxel_count> voxels_;
    Voxel lower_{grid_side, grid_side, grid_side}, upper_{0, 0, 0};
    bool outside_ = false;
};

/// Voxel sets as boxes, ready to be tested against many paths.
class Regions {
  public:
    /// Most boxes of a set, by default: beyond that they are fewer and coarser, for every path is
    /// tested against each.
    static constexpr std::size_t few_boxes = 24;

    /// Adds the voxels of `set`, cut to `bounds` (in voxels), as at most `most_boxes` boxes.
    void add(const VoxelSet& set, const trace::Box& bounds, std::size_t most_boxes = few_boxes);

    [[nodiscard]] bool empty() const { return !outside_ && boxes_.empty(); }
    /// Whether a segment of this path may meet one of the voxels.
    [[nodiscard]] bool may_meet(Path path) const;

  private:
    /// In voxels, enlarged so that the hull of two voxels meets the original where the line between
    /// their centres meets this.
    struct Enlarged {
        float lower[3], upper[3];
    };
    [[nodiscard]] static bool apart(const Enlarged& box, const float* from, const float* to);

    std::vector<Enlarged> boxes_;
    Enlarged all_{{1e9f, 1e9f, 1e9f}, {-1e9f, -1e9f, -1e9f}};  ///< around them
    bool outside_ = false;
};

/// A uniform grid over a box of render space.
class VoxelGrid {
  public:
    /// Footprints are dilated by this share of a voxel on every side, and so are hulls: hits,
    /// secondary origins and the arithmetic here err by less than 2^-20 of the grid, which is 2^-16
    /// of a voxel (DESIGN 3, rule 8).
    static constexpr double dilation = 0x1p-6;

    VoxelGrid() = default;
    explicit VoxelGrid(const trace::Box& scene);

    /// The path of origin + t direction for t from 0 to `t_end`, which may be infinite. No
    /// component of `direction` is zero.
    [[nodiscard]] Path path(const V3f& origin, const V3f& direction, double t_end) const;

    /// Render space to voxels: voxel (i, j, k) is [i, i + 1] x [j, j + 1] x [k, k + 1].
    [[nodiscard]] V3d in_voxels(const V3d& p) const {
        return {(p.x - box_.lower.x) * per_unit_.x, (p.y - box_.lower.y) * per_unit_.y,
                (p.z - box_.lower.z) * per_unit_.z};
    }

    /// For checkpoints (checkpoint/arrays.h).
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self) {
        auto& [box, per_unit] = self;
        to.value(name + "box", box);
        to.value(name + "per_unit", per_unit);
    }

  private:
    [[nodiscard]] std::uint32_t voxel_at(const V3d& p) const;

    trace::Box box_;
    V3d per_unit_{1, 1, 1};
};

}  // namespace irt::history
