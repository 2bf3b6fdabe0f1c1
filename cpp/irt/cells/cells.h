// SPDX-License-Identifier: Apache-2.0
// The 64 cells: fixed, interleaved shares of the pixels, after the paper's 64 processors
// (section 5; DESIGN 6).
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace irt::cells {

inline constexpr int cell_count = 64;
inline constexpr int cell_stride = 8;

/// Column and row, within each 8x8 block of the full frame, of the pixels of cell `k`: pixel (x, y)
/// belongs to cell (x mod 8) + 8 (y mod 8).
struct CellOffset {
    int x, y;
};
constexpr CellOffset cell_offset(int k) { return {k % cell_stride, k / cell_stride}; }

/// A host's hold on a running update; written and read from any thread.
struct Control {
    std::atomic<bool> stop = false;  ///< set to stop the update at its next step
    std::atomic<int> steps_done = 0, steps = 1;
    std::atomic<int> views = 1, view = 0;  ///< updated one after the other

    void begin_view(int v) {
        steps_done = 0;
        view = v;
    }
    [[nodiscard]] double progress() const {
        return (view + static_cast<double>(steps_done) / steps) / views;
    }
};

/// The cells that are rendered, each once, in the order in which they are handed out. The order
/// shows in no result; pixels of other cells stay black.
using CellOrder = std::vector<int>;
CellOrder natural_order();  ///< all of them

/// Cells that one task runs together. In natural order their pixels are neighbours, so that their
/// rays meet the same parts of the scene.
using CellGroup = std::span<const int>;

/// `threads` as asked for, or, where that is 0, all of the machine.
int thread_count(int threads);

/// Runs `body(task)` for each task from 0 to `count` - 1 on `threads` threads (0: all of the
/// machine), every one in IEEE default floating-point state. A thread that is done takes the next.
void for_each_task(int threads, int count, const std::function<void(int task)>& body);

/// Splits the cells of `order` into `groups` of as equal a size as can be and runs `body(group)`
/// for each on `threads` threads as tasks. Cells share no pixel and no tree.
void for_each_group(int threads, int groups, const CellOrder& order,
                    const std::function<void(CellGroup group)>& body);

}  // namespace irt::cells
