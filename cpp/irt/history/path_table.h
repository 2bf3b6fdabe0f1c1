// SPDX-License-Identifier: Apache-2.0
// The paper's hash table (section 3.1): each path once, shared by all rays that take it, with a
// flag that says whether anything on it changed. "Did this ray change?" is then one look-up.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "irt/history/voxel_grid.h"

namespace irt::history {

/// A ray's hash index: its path's place in the table.
using PathIndex = std::uint32_t;

/// The place of what is no ray (free nodes, lights that need none); it is never flagged.
inline constexpr PathIndex no_path = 0;
/// The place of every path that found the table full around its own: always flagged.
inline constexpr PathIndex any_path = 1;

class PathTable {
  public:
    /// Empties the table and makes room for `entries` paths; `asks_reach`: and for the answers of
    /// `reaches`.
    void reset(const VoxelGrid& grid, std::size_t entries, bool asks_reach);

    [[nodiscard]] const VoxelGrid& grid() const { return grid_; }

    /// The place of `path`, entered by linear probing if it is new. Callable from any thread
    /// without locks; which place a path gets may depend on their order and shows in no result.
    PathIndex intern(Path path);

    /// Clears all flags, then scans the places [begin, end) and flags the paths that may meet
    /// `regions`. Ranges that begin at multiples of `flag_block` may be scanned at once.
    void clear_flags();
    void flag(const Regions& regions, std::size_t begin, std::size_t end);
    static constexpr std::size_t flag_block = 64;

    [[nodiscard]] bool flagged(PathIndex index) const {
        return (flags_[index / flag_block] >> (index % flag_block) & 1) != 0;
    }

    /// Whether the path at `index` may meet `regions`, which must be the same ones until the next
    /// reset: the answer is kept. Callable from any thread.
    [[nodiscard]] bool reaches(PathIndex index, const Regions& regions);

    /// The path at a place that is neither no_path nor any_path.
    [[nodiscard]] Path path(PathIndex index) const {
        return paths_[index].load(std::memory_order_relaxed);
    }
    [[nodiscard]] std::size_t capacity() const { return capacity_; }
    [[nodiscard]] std::size_t entries() const;
    [[nodiscard]] std::size_t bytes() const {
        return capacity_ * sizeof(Path) + flags_.size() * sizeof(std::uint64_t);
    }

  private:
    VoxelGrid grid_;
    std::size_t capacity_ = 0;  ///< a power of two, or 0
    unsigned shift_ = 32;
    std::unique_ptr<std::atomic<Path>[]> paths_;
    enum Answer : std::uint8_t { unknown, no, yes };
    std::unique_ptr<std::atomic<std::uint8_t>[]> reaches_;  ///< null: not to be asked
    std::vector<std::uint64_t> flags_;                      ///< a bit a place
};

}  // namespace irt::history
