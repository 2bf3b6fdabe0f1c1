// SPDX-License-Identifier: Apache-2.0
#include "irt/history/voxel_grid.h"

#include <algorithm>
#include <cmath>

namespace irt::history {

namespace {

constexpr std::uint32_t voxel_mask = (1u << voxel_bits) - 1;

/// The grid exceeds the scene by these shares of its size: room for objects that move out of it,
/// whose going would flag every ray that leaves the grid. Odd shares, so that authored planes do
/// not lie on voxel faces.
constexpr double margin_below = 0.2236067977, margin_above = 0.2118033989;

}  // namespace

trace::Box crowded_box(std::vector<trace::Box> boxes) {
    trace::Box crowd;
    if (boxes.empty()) return crowd;
    const auto length = [](const trace::Box& box) { return (box.upper - box.lower).length(); };
    const auto middle = boxes.begin() + static_cast<std::ptrdiff_t>(boxes.size() / 2);
    std::nth_element(
        boxes.begin(), middle, boxes.end(),
        [&](const trace::Box& a, const trace::Box& b) { return length(a) < length(b); });
    const double limit = giant * length(*middle);
    for (const trace::Box& box : boxes)
        if (length(box) <= limit) crowd.extend(box);
    return crowd;
}

VoxelGrid::VoxelGrid(const trace::Box& scene) {
    for (int a = 0; a < 3; ++a) {
        const double lower = scene.empty() ? -1 : scene.lower[a];
        const double upper = scene.empty() ? 1 : scene.upper[a];
        const double size = std::max(
            {upper - lower, 0x1p-16 * std::fabs(lower), 0x1p-16 * std::fabs(upper), 1e-30});
        box_.lower[a] = lower - margin_below * size;
        box_.upper[a] = upper + margin_above * size;
        voxel_[a] = (box_.upper[a] - box_.lower[a]) / grid_side;
        per_unit_[a] = 1 / voxel_[a];
    }
}

std::uint32_t VoxelGrid::voxel_at(const V3d& p) const {
    std::uint32_t voxel = 0;
    for (int a = 2; a >= 0; --a) {
        const double cell = std::floor((p[a] - box_.lower[a]) * per_unit_[a]);
        const auto index = static_cast<std::uint32_t>(std::clamp(cell, 0.0, grid_side - 1.0));
        voxel = voxel * grid_side + index;
    }
    return voxel;
}

V3d VoxelGrid::centre_of(std::uint32_t voxel) const {
    V3d p;
    for (int a = 0; a < 3; ++a) {
        p[a] = box_.lower[a] + (voxel % grid_side + 0.5) * voxel_[a];
        voxel /= grid_side;
    }
    return p;
}

Path VoxelGrid::path(const V3f& origin, const V3f& direction, double t_end) const {
    const V3d o(origin), d(direction);
    double enter = 0, exit = t_end;
    if (!trace::clip(box_, o, d, enter, exit)) return path_nowhere | path_outside;
    const bool outside = enter > 0 || exit < t_end;
    return voxel_at(o + d * enter) | voxel_at(o + d * exit) << voxel_bits |
           (outside ? path_outside : 0);
}

bool VoxelGrid::may_meet(Path path, const trace::Box& box) const {
    if (path & path_outside)
        for (int a = 0; a < 3; ++a)
            if (box.lower[a] < box_.lower[a] || box.upper[a] > box_.upper[a]) return true;
    if (path & path_nowhere) return false;
    // The hull of two equal boxes meets `box` where the line between their centres meets `box`
    // enlarged by half of theirs.
    trace::Box enlarged = box;
    for (int a = 0; a < 3; ++a) {
        enlarged.lower[a] -= voxel_[a] * (0.5 + dilation);
        enlarged.upper[a] += voxel_[a] * (0.5 + dilation);
    }
    const V3d from = centre_of(path & voxel_mask), to = centre_of(path >> voxel_bits & voxel_mask);
    double enter = 0, exit = 1;
    return trace::clip(enlarged, from, to - from, enter, exit);
}

}  // namespace irt::history
