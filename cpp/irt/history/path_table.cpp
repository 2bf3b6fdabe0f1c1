// SPDX-License-Identifier: Apache-2.0
#include "irt/history/path_table.h"

#include <algorithm>
#include <bit>

namespace irt::history {

namespace {

constexpr Path empty_place = 0xffffffffu;
constexpr std::size_t least_capacity = 1u << 10;
constexpr PathIndex first_place = 2;

/// Probes after which a path goes to any_path: tables are made at most half full, where one in a
/// million needs so many.
constexpr int most_probes = 64;

}  // namespace

void PathTable::reset(const VoxelGrid& grid, std::size_t entries, bool asks_reach) {
    grid_ = grid;
    const std::size_t capacity = std::max(least_capacity, std::bit_ceil(2 * entries));
    if (capacity != capacity_) {
        capacity_ = capacity;
        paths_ = std::make_unique<std::atomic<Path>[]>(capacity);
    }
    for (std::size_t i = 0; i < capacity_; ++i)
        paths_[i].store(empty_place, std::memory_order_relaxed);
    flags_.assign(capacity_ / flag_block, 0);
    reaches_.reset(asks_reach ? new std::atomic<std::uint8_t>[capacity_]() : nullptr);
}

PathIndex PathTable::intern(Path path) {
    PathIndex place = place_of(path);
    for (int probe = 0; probe < most_probes; ++probe) {
        if (place < first_place) place = first_place;
        std::atomic<Path>& slot = paths_[place];
        Path found = slot.load(std::memory_order_relaxed);
        if (found == empty_place &&
            slot.compare_exchange_strong(found, path, std::memory_order_relaxed))
            return place;
        if (found == path) return place;
        place = (place + 1) & static_cast<PathIndex>(capacity_ - 1);
    }
    return any_path;
}

bool PathTable::reaches(PathIndex index, const Regions& regions) {
    if (index == any_path) return true;
    std::uint8_t answer = reaches_[index].load(std::memory_order_relaxed);
    if (answer == unknown) {
        answer = regions.may_meet(path(index)) ? yes : no;
        reaches_[index].store(answer, std::memory_order_relaxed);
    }
    return answer == yes;
}

void PathTable::clear_flags() {
    std::fill(flags_.begin(), flags_.end(), 0);
    flags_[0] = 1u << any_path;
    if (without(Structure::path_flags)) {
        std::fill(flags_.begin(), flags_.end(), ~0u);
        flags_[0] &= ~(1u << no_path);
    }
}

void PathTable::flag(const Regions& regions, std::size_t begin, std::size_t end) {
    for (std::size_t i = std::max<std::size_t>(begin, first_place); i < end; ++i) {
        const Path path = paths_[i].load(std::memory_order_relaxed);
        if (path != empty_place && regions.may_meet(path))
            flags_[i / flag_block] |= 1u << (i % flag_block);
    }
}

std::size_t PathTable::entries() const {
    std::size_t count = 0;
    for (std::size_t i = first_place; i < capacity_; ++i)
        count += paths_[i].load(std::memory_order_relaxed) != empty_place;
    return count;
}

}  // namespace irt::history
