// SPDX-License-Identifier: Apache-2.0
// The paper's hash table (section 3.1): each path once, shared by all rays that take it, with a
// flag that says whether anything on it changed. "Did this ray change?" is then one look-up.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "irt/history/voxel_grid.h"

namespace irt::history {

/// A ray's hash index: its path's place in the table.
using PathIndex = std::uint32_t;

/// Entry 0 is the path of what is no ray (free nodes, lights that need none); it is never flagged.
inline constexpr PathIndex no_path = 0;

class PathTable {
  public:
    void reset(const VoxelGrid& grid);

    [[nodiscard]] const VoxelGrid& grid() const { return grid_; }

    /// The index of `path`, entered if it is new. Callable from any thread; which index a path gets
    /// may depend on their order and shows in no result.
    PathIndex intern(Path path);

    /// Scans the table once: flags every entry that may meet one of `changed`.
    void flag(const std::vector<trace::Box>& changed);
    [[nodiscard]] bool flagged(PathIndex index) const {
        return index < flags_.size() && flags_[index] != 0;
    }

  private:
    static constexpr std::uint32_t shard_count = 64;
    struct Shard {
        std::mutex mutex;
        std::unordered_map<Path, PathIndex> index_of;
        std::vector<Path> paths;  ///< entry i of shard s has index 1 + s + i * shard_count
    };
    VoxelGrid grid_;
    std::array<Shard, shard_count> shards_;
    std::vector<std::uint8_t> flags_;
};

}  // namespace irt::history
