// SPDX-License-Identifier: Apache-2.0
// The hash table of paths, its flags, and the voxel sets that set them (paper, sections 2.3, 3.1).
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "irt/history/path_table.h"

namespace irt::history {
namespace {

/// The segment from one point to another, both in voxels, as a path of `grid`.
Path segment(const VoxelGrid& grid, const V3d& from, const V3d& to) {
    const V3d zero = grid.in_voxels(V3d(0)), unit = grid.in_voxels(V3d(1)) - zero;
    const auto place = [&](const V3d& v) { return (v - zero) / unit; };
    const V3f origin(place(from));
    return grid.path(origin, V3f(place(to) - V3d(origin)), 1);
}

Regions regions_of(const VoxelSet& set) {
    Regions regions;
    trace::Box all;
    all.extend(V3d(0));
    all.extend(V3d(grid_side));
    regions.add(set, all);
    return regions;
}

// ---- the paper's figure 5

/// Its voxels are numbered row by row, eight to a row; here they lie in one layer of the grid.
constexpr std::int32_t row_length = 8, layer = 9;
Voxel figure_voxel(std::int32_t number) {
    return {number % row_length, number / row_length, layer};
}

/// The voxels of a straight line, in the figure's numbers, in order.
std::vector<std::int32_t> passed(const V2d& from, const V2d& to) {
    std::vector<std::int32_t> voxels;
    constexpr int steps = 100000;
    for (int i = 0; i <= steps; ++i) {
        const V2d p = from + (to - from) * (static_cast<double>(i) / steps);
        const auto voxel =
            static_cast<std::int32_t>(p.x) + row_length * static_cast<std::int32_t>(p.y);
        if (voxels.empty() || voxels.back() != voxel) voxels.push_back(voxel);
    }
    return voxels;
}

/// Both rays pass the very voxels that the figure says. An entry here is not their set but the hull
/// of the first and the last; it is flagged by every voxel of that set, and by voxel 13 the second
/// ray's entry is not, though the hull is wider than its set.
TEST(PathTable, FigureFive) {
    const V2d first_from(6.3, 0.2), first_to(2.7, 3.8), second_from(3.1, 0.5), second_to(4.45, 3.5);
    const std::vector<std::int32_t> first = passed(first_from, first_to),
                                    second = passed(second_from, second_to);
    ASSERT_EQ(first, (std::vector<std::int32_t>{6, 5, 13, 12, 20, 19, 27, 26}));
    ASSERT_EQ(second, (std::vector<std::int32_t>{3, 11, 19, 20, 28}));

    trace::Box scene;
    scene.extend(V3d(-3, 1, 5));
    scene.extend(V3d(4, 2, 11));
    PathTable table;
    table.reset(VoxelGrid(scene), 100, false);
    const auto entry = [&](const V2d& from, const V2d& to) {
        constexpr double z = layer + 0.5;
        return table.intern(
            segment(table.grid(), V3d(from.x, from.y, z), V3d(to.x, to.y, z + 0.01)));
    };
    const PathIndex h2 = entry(first_from, first_to), h1 = entry(second_from, second_to);
    // By ray coherence rays beside them share their entries.
    EXPECT_EQ(entry(first_from + V2d(0.01, 0.02), first_to), h2);
    ASSERT_NE(h1, h2);

    const auto flag = [&](std::int32_t voxel) {
        VoxelSet changed;
        changed.add(figure_voxel(voxel));
        table.clear_flags();
        table.flag(regions_of(changed), 0, table.capacity());
    };
    flag(13);
    EXPECT_TRUE(table.flagged(h2));
    EXPECT_FALSE(table.flagged(h1));
    for (const std::int32_t voxel : first) {
        flag(voxel);
        EXPECT_TRUE(table.flagged(h2)) << voxel;
    }
    for (const std::int32_t voxel : second) {
        flag(voxel);
        EXPECT_TRUE(table.flagged(h1)) << voxel;
    }
    flag(7);
    EXPECT_FALSE(table.flagged(h1));
}

// ---- sets of voxels

Path path_of(const Voxel& first, const Voxel& last) {
    const auto index = [](const Voxel& v) {
        return (static_cast<Path>(v[2]) * grid_side + static_cast<Path>(v[1])) * grid_side +
               static_cast<Path>(v[0]);
    };
    return index(first) | index(last) << voxel_bits;
}

/// Whether the hull of two voxels meets a third, by the line between the centres of the two and the
/// third grown by half a voxel on every side.
bool hull_meets(const Voxel& first, const Voxel& last, const Voxel& voxel) {
    trace::Box grown;
    V3d from, to;
    for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        grown.lower[a] = voxel[axis] - 0.5;
        grown.upper[a] = voxel[axis] + 1.5;
        from[a] = first[axis] + 0.5;
        to[a] = last[axis] + 0.5;
    }
    double enter = 0, exit = 1;
    return trace::clip(grown, from, to - from, enter, exit);
}

TEST(Regions, TheirBoxesCoverTheirSets) {
    std::mt19937 random(4);
    const auto below = [&](std::uint32_t n) { return static_cast<std::int32_t>(random() % n); };
    const auto any = [&] { return Voxel{below(grid_side), below(grid_side), below(grid_side)}; };
    std::size_t met = 0, spared = 0;
    for (int round = 0; round < 60; ++round) {
        // Loose voxels, a block, or so many pieces that the set is taken in coarse blocks.
        VoxelSet set;
        std::vector<Voxel> voxels;
        const auto add = [&](const Voxel& voxel) {
            set.add(voxel);
            voxels.push_back(voxel);
        };
        for (std::int32_t i = 0; i < 1 << (round % 8); ++i) add(any());
        const Voxel corner = any();
        for (std::int32_t z = corner[2]; z < std::min<std::int32_t>(corner[2] + 3, grid_side); ++z)
            for (std::int32_t x = corner[0]; x < std::min<std::int32_t>(corner[0] + 5, grid_side);
                 ++x)
                add({x, corner[1], z});
        const Regions regions = regions_of(set);
        for (const Voxel& voxel : voxels) {
            EXPECT_TRUE(regions.may_meet(path_of(voxel, voxel)));
            EXPECT_TRUE(regions.may_meet(path_of(voxel, any())));
            EXPECT_TRUE(regions.may_meet(path_of(any(), voxel)));
        }
        for (int i = 0; i < 3000; ++i) {
            const Voxel first = any(), last = any();
            bool meets = false;
            for (const Voxel& voxel : voxels) meets = meets || hull_meets(first, last, voxel);
            const bool may_meet = regions.may_meet(path_of(first, last));
            ASSERT_TRUE(may_meet || !meets);
            met += meets;
            spared += !may_meet;
        }
    }
    EXPECT_GT(met, 10000u);
    EXPECT_GT(spared, 10000u);
}

TEST(Regions, WhatLeavesTheGridMeetsWhatChangedOutside) {
    VoxelSet outside, inside;
    outside.add_outside();
    inside.add({1, 1, 1});
    const Regions changed_outside = regions_of(outside), changed_inside = regions_of(inside);
    EXPECT_FALSE(changed_outside.empty());
    EXPECT_TRUE(changed_outside.may_meet(path_nowhere | path_outside));
    EXPECT_TRUE(changed_outside.may_meet(path_of({3, 3, 3}, {4, 4, 4}) | path_outside));
    EXPECT_FALSE(changed_outside.may_meet(path_of({3, 3, 3}, {4, 4, 4})));
    EXPECT_FALSE(changed_inside.may_meet(path_nowhere | path_outside));
    EXPECT_TRUE(Regions().empty());
    EXPECT_FALSE(Regions().may_meet(path_nowhere | path_outside));
}

// ---- the table

TEST(PathTable, ThreadsThatInternAtOnceShareEntries) {
    PathTable table;
    table.reset(VoxelGrid(), 20000, false);
    constexpr std::size_t threads = 4, lookups = 40000;
    std::vector<std::vector<std::pair<Path, PathIndex>>> found(threads);
    std::vector<std::thread> running;
    for (std::size_t t = 0; t < threads; ++t)
        running.emplace_back([&, t] {
            std::mt19937 random(static_cast<unsigned>(t));
            for (std::size_t i = 0; i < lookups; ++i) {
                const Path path = static_cast<Path>(random() % 12000) * 7919u & 0x3fffffffu;
                found[t].emplace_back(path, table.intern(path));
            }
        });
    for (std::thread& thread : running) thread.join();
    std::map<Path, PathIndex> places;
    for (const auto& list : found)
        for (const auto& [path, place] : list) {
            ASSERT_GT(place, any_path);
            ASSERT_EQ(table.path(place), path);
            ASSERT_EQ(places.try_emplace(path, place).first->second, place);
        }
    EXPECT_EQ(table.entries(), places.size());
}

TEST(PathTable, PathsThatFindNoPlaceAreAlwaysFlagged) {
    PathTable table;
    table.reset(VoxelGrid(), 0, false);
    std::mt19937 random(5);
    std::size_t crowded_out = 0;
    for (std::size_t i = 0; i < 4 * table.capacity(); ++i) {
        const Path path = static_cast<Path>(random()) & 0x3fffffffu;
        const PathIndex place = table.intern(path);
        ASSERT_NE(place, no_path);
        if (place == any_path)
            ++crowded_out;
        else
            ASSERT_EQ(table.path(place), path);
    }
    EXPECT_GT(crowded_out, table.capacity());
    EXPECT_LE(table.entries(), table.capacity() - 2);
    table.clear_flags();
    EXPECT_TRUE(table.flagged(any_path));
    EXPECT_FALSE(table.flagged(no_path));
    table.flag(Regions(), 0, table.capacity());
    for (PathIndex place = any_path + 1; place < table.capacity(); ++place)
        ASSERT_FALSE(table.flagged(place));
    EXPECT_TRUE(table.flagged(any_path));
}

TEST(PathTable, EmptiedTablesForgetTheirPaths) {
    PathTable table;
    table.reset(VoxelGrid(), 100, false);
    (void)table.intern(path_of({1, 2, 3}, {4, 5, 6}));
    EXPECT_EQ(table.entries(), 1u);
    table.reset(VoxelGrid(), 100, false);
    EXPECT_EQ(table.entries(), 0u);
}

}  // namespace
}  // namespace irt::history
