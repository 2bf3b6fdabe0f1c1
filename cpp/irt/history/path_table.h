// SPDX-License-Identifier: Apache-2.0
// The paper's hash table (section 3.1): each path once, shared by all rays that take it, with a
// flag that says whether anything on it changed. "Did this ray change?" is then one look-up.
#pragma once

#include <immintrin.h>

#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
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
    /// Fetches where `path` may be, to be called some time before it is interned.
    void fetch(Path path) const { __builtin_prefetch(&paths_[place_of(path)], 1); }

    /// Clears all flags, then scans the places [begin, end) and flags the paths that may meet
    /// `regions`. Ranges that begin at multiples of `flag_block` may be scanned at once.
    void clear_flags();
    void flag(const Regions& regions, std::size_t begin, std::size_t end);
    static constexpr std::size_t flag_block = 32;

    [[nodiscard]] bool flagged(PathIndex index) const {
        return (flags_[index / flag_block] >> (index % flag_block) & 1) != 0;
    }
    /// Calls found(i) for each i, in order, of which indices[i] is flagged.
    template <class Found>
    void for_each_flagged(std::span<const PathIndex> indices, Found&& found) const;

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
        return capacity_ * sizeof(Path) + flags_.size() * sizeof(std::uint32_t);
    }

    /// For checkpoints (checkpoint/arrays.h). Flags and answers are not kept: each update, and each
    /// recording, makes its own.
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self) {
        auto& [grid, capacity, paths, reaches, flags] = self;
        static_assert(sizeof(std::atomic<Path>) == sizeof(Path));
        if constexpr (Archive::reads) {
            VoxelGrid kept;
            VoxelGrid::archive(to, name + "grid.", kept);
            std::vector<Path> places;
            to.array(name + "paths", places);
            if (!std::has_single_bit(places.size()))
                throw std::runtime_error(name + "paths: holds no power of two");
            self.reset(kept, places.size() / 2, false);
            if (capacity != places.size())
                throw std::runtime_error(name + "paths: is of a size that no table has");
            for (std::size_t i = 0; i < places.size(); ++i)
                paths[i].store(places[i], std::memory_order_relaxed);
        } else {
            VoxelGrid::archive(to, name + "grid.", grid);
            to.array(name + "paths",
                     std::span(reinterpret_cast<const Path*>(paths.get()), capacity));
        }
    }

  private:
    /// Where probing for `path` begins. Paths are regular: one multiplication would leave clusters
    /// (this is the finalizer of MurmurHash3, 32 bit).
    [[nodiscard]] PathIndex place_of(Path path) const {
        path = (path ^ path >> 16) * 0x85ebca6bu;
        path = (path ^ path >> 13) * 0xc2b2ae35u;
        return (path ^ path >> 16) & static_cast<PathIndex>(capacity_ - 1);
    }

    VoxelGrid grid_;
    std::size_t capacity_ = 0;  ///< a power of two, or 0
    std::unique_ptr<std::atomic<Path>[]> paths_;
    enum Answer : std::uint8_t { unknown, no, yes };
    std::unique_ptr<std::atomic<std::uint8_t>[]> reaches_;  ///< null: not to be asked
    std::vector<std::uint32_t> flags_;                      ///< a bit a place
};

template <class Found>
void PathTable::for_each_flagged(std::span<const PathIndex> indices, Found&& found) const {
    const auto* words = reinterpret_cast<const int*>(flags_.data());
    const __m256i low = _mm256_set1_epi32(flag_block - 1);
    std::size_t i = 0;
    for (; i + 8 <= indices.size(); i += 8) {
        const __m256i index =
            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(indices.data() + i));
        const __m256i word = _mm256_i32gather_epi32(words, _mm256_srli_epi32(index, 5), 4);
        // Shifted so that each flag is a sign.
        const __m256i sign =
            _mm256_sllv_epi32(word, _mm256_sub_epi32(low, _mm256_and_si256(index, low)));
        auto bits = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(sign)));
        for (; bits != 0; bits &= bits - 1)
            found(i + static_cast<std::size_t>(std::countr_zero(bits)));
    }
    for (; i < indices.size(); ++i)
        if (flagged(indices[i])) found(i);
}

}  // namespace irt::history
