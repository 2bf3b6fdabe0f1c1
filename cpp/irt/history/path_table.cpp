// SPDX-License-Identifier: Apache-2.0
#include "irt/history/path_table.h"

#include <algorithm>

namespace irt::history {

void PathTable::reset(const VoxelGrid& grid) {
    grid_ = grid;
    flags_.clear();
    for (Shard& shard : shards_) {
        shard.index_of.clear();
        shard.paths.clear();
    }
}

PathIndex PathTable::intern(Path path) {
    const std::uint32_t s = path * 0x9e3779b1u >> 26;
    Shard& shard = shards_[s];
    const std::lock_guard lock(shard.mutex);
    const auto next = static_cast<PathIndex>(1 + s + shard.paths.size() * shard_count);
    const auto [entry, added] = shard.index_of.try_emplace(path, next);
    if (added) shard.paths.push_back(path);
    return entry->second;
}

void PathTable::flag(const std::vector<trace::Box>& changed) {
    std::size_t most = 0;
    for (const Shard& shard : shards_) most = std::max(most, shard.paths.size());
    flags_.assign(1 + most * shard_count, 0);
    for (std::uint32_t s = 0; s < shard_count; ++s)
        for (std::size_t i = 0; i < shards_[s].paths.size(); ++i)
            for (const trace::Box& box : changed)
                if (grid_.may_meet(shards_[s].paths[i], box)) {
                    flags_[1 + s + i * shard_count] = 1;
                    break;
                }
}

}  // namespace irt::history
