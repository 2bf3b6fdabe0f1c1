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

struct VoxelBox {
    Voxel lower, upper;
};

/// Whether all voxels of `box` are in `set` and not yet in `done`.
bool all_new(const VoxelSet& set, const VoxelSet& done, const VoxelBox& box) {
    for (std::int32_t z = box.lower[2]; z < box.upper[2]; ++z)
        for (std::int32_t y = box.lower[1]; y < box.upper[1]; ++y)
            for (std::int32_t x = box.lower[0]; x < box.upper[0]; ++x)
                if (!set.has({x, y, z}) || done.has({x, y, z})) return false;
    return true;
}

/// Calls body(voxel) for the voxels of `set` in order.
template <class Body>
void for_each_voxel(const VoxelSet& set, Body&& body) {
    for (std::int32_t z = set.lower()[2]; z < set.upper()[2]; ++z)
        for (std::int32_t y = set.lower()[1]; y < set.upper()[1]; ++y)
            for (std::int32_t x = set.lower()[0]; x < set.upper()[0]; ++x)
                if (set.has({x, y, z})) body(Voxel{x, y, z});
}

/// The set as boxes that do not overlap. Greedy: from each voxel left, the longest run along x,
/// grown along y, then along z.
std::vector<VoxelBox> boxes_of(const VoxelSet& set) {
    std::vector<VoxelBox> boxes;
    VoxelSet done;
    for_each_voxel(set, [&](const Voxel& voxel) {
        if (done.has(voxel)) return;
        VoxelBox box{voxel, {voxel[0] + 1, voxel[1] + 1, voxel[2] + 1}};
        for (std::size_t axis = 0; axis < 3; ++axis)
            while (box.upper[axis] < set.upper()[axis]) {
                VoxelBox next = box;
                next.lower[axis] = box.upper[axis];
                next.upper[axis] = box.upper[axis] + 1;
                if (!all_new(set, done, next)) break;
                ++box.upper[axis];
            }
        for (std::int32_t z = box.lower[2]; z < box.upper[2]; ++z)
            for (std::int32_t y = box.lower[1]; y < box.upper[1]; ++y)
                for (std::int32_t x = box.lower[0]; x < box.upper[0]; ++x) done.add({x, y, z});
        boxes.push_back(box);
    });
    return boxes;
}

/// The set in blocks of `size` voxels a side, whole where one of their voxels is in it.
VoxelSet in_blocks(const VoxelSet& set, std::int32_t size) {
    VoxelSet coarse;
    for_each_voxel(set, [&](const Voxel& voxel) {
        const std::int32_t x = voxel[0] / size * size, y = voxel[1] / size * size,
                           z = voxel[2] / size * size;
        if (coarse.has({x, y, z})) return;
        for (std::int32_t k = z; k < z + size; ++k)
            for (std::int32_t j = y; j < y + size; ++j)
                for (std::int32_t i = x; i < x + size; ++i) coarse.add({i, j, k});
    });
    return coarse;
}

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

void Regions::add(const VoxelSet& set, const trace::Box& within, std::size_t most_boxes) {
    trace::Box bounds = within;
    if (without(Structure::region_bounds)) bounds = {V3d(0), V3d(grid_side)};
    outside_ = outside_ || set.outside();
    std::vector<VoxelBox> boxes = boxes_of(set);
    for (std::int32_t size = 2; boxes.size() > most_boxes; size *= 2)
        boxes = boxes_of(in_blocks(set, size));
    const double reach = 0.5 + (mutated(Mutant::no_dilation) ? 0 : 2 * VoxelGrid::dilation);
    if (mutated(Mutant::dropped_voxel) && !boxes.empty()) boxes.erase(boxes.begin());
    for (const VoxelBox& box : boxes) {
        Enlarged enlarged{};
        for (int a = 0; a < 3; ++a) {
            const auto axis = static_cast<std::size_t>(a);
            enlarged.lower[a] =
                static_cast<float>(std::max<double>(box.lower[axis], bounds.lower[a]) - reach);
            enlarged.upper[a] =
                static_cast<float>(std::min<double>(box.upper[axis], bounds.upper[a]) + reach);
        }
        boxes_.push_back(enlarged);
        for (int a = 0; a < 3; ++a) {
            all_.lower[a] = std::min(all_.lower[a], enlarged.lower[a]);
            all_.upper[a] = std::max(all_.upper[a], enlarged.upper[a]);
        }
    }
}

/// Whether a face of `box` parts it from the line between two points.
bool Regions::apart(const Enlarged& box, const float* from, const float* to) {
    bool parted = false;
    for (int a = 0; a < 3; ++a)
        parted = parted || std::max(from[a], to[a]) < box.lower[a] ||
                 std::min(from[a], to[a]) > box.upper[a];
    return parted;
}

bool Regions::may_meet(Path path) const {
    if ((path & path_outside) && outside_) return true;
    if (path & path_nowhere) return false;
    float from[3], to[3];
    std::uint32_t first = path & voxel_mask, last = path >> voxel_bits & voxel_mask;
    for (int a = 0; a < 3; ++a) {
        from[a] = static_cast<float>(first % grid_side) + 0.5f;
        to[a] = static_cast<float>(last % grid_side) + 0.5f;
        first /= grid_side;
        last /= grid_side;
    }
    if (apart(all_, from, to)) return false;
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const Enlarged& box) {
        if (apart(box, from, to)) return false;
        float enter = 0, exit = 1;
        for (int a = 0; a < 3; ++a) {
            const float length = to[a] - from[a];
            if (length == 0) continue;
            const float inverse = 1 / length;
            const float t0 = (box.lower[a] - from[a]) * inverse,
                        t1 = (box.upper[a] - from[a]) * inverse;
            enter = std::max(enter, std::min(t0, t1));
            exit = std::min(exit, std::max(t0, t1));
        }
        return enter <= exit;
    });
}

VoxelGrid::VoxelGrid(const trace::Box& scene) {
    for (int a = 0; a < 3; ++a) {
        const double lower = scene.empty() ? -1 : scene.lower[a];
        const double upper = scene.empty() ? 1 : scene.upper[a];
        const double size = std::max(
            {upper - lower, 0x1p-16 * std::fabs(lower), 0x1p-16 * std::fabs(upper), 1e-30});
        box_.lower[a] = lower - margin_below * size;
        box_.upper[a] = upper + margin_above * size;
        per_unit_[a] = grid_side / (box_.upper[a] - box_.lower[a]);
    }
}

std::uint32_t VoxelGrid::voxel_at(const V3d& p) const {
    std::uint32_t voxel = 0;
    for (int a = 2; a >= 0; --a) {
        const double cell = (p[a] - box_.lower[a]) * per_unit_[a];
        const auto index = static_cast<std::uint32_t>(std::clamp(cell, 0.0, grid_side - 1.0));
        voxel = voxel * grid_side + index;
    }
    return voxel;
}

Path VoxelGrid::path(const V3f& origin, const V3f& direction, double t_end) const {
    const V3d o(origin), d(direction);
    double enter = 0, exit = t_end;
    if (!trace::clip(box_, o, d, enter, exit)) return path_nowhere | path_outside;
    const bool outside = enter > 0 || exit < t_end;
    return voxel_at(o + d * enter) | voxel_at(o + d * exit) << voxel_bits |
           (outside ? path_outside : 0);
}

}  // namespace irt::history
