// SPDX-License-Identifier: Apache-2.0
#include "irt/cells/cells.h"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <numeric>

#include "irt/math/float_state.h"

namespace irt::cells {

namespace {

/// TBB makes no more threads than the machine has, and complains where more are asked for.
int arena_slots(int threads) {
    return std::min(thread_count(threads), oneapi::tbb::info::default_concurrency());
}

}  // namespace

CellOrder natural_order() {
    CellOrder order;
    std::iota(order.begin(), order.end(), 0);
    return order;
}

int thread_count(int threads) {
    return threads > 0 ? threads : oneapi::tbb::info::default_concurrency();
}

void for_each_group(int threads, int groups, const CellOrder& order,
                    const std::function<void(CellGroup group)>& body) {
    oneapi::tbb::task_arena arena(arena_slots(threads));
    const std::size_t count = static_cast<std::size_t>(std::clamp(groups, 1, cell_count));
    const auto first_of = [count](std::size_t group) { return group * cell_count / count; };
    arena.execute([&] {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range<std::size_t>(0, count, 1),
            [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                const FloatState ieee;
                for (std::size_t g = range.begin(); g < range.end(); ++g)
                    body(CellGroup(order).subspan(first_of(g), first_of(g + 1) - first_of(g)));
            },
            oneapi::tbb::simple_partitioner());
    });
}

void for_each_range(int threads, int count, const std::function<void(int begin, int end)>& body) {
    oneapi::tbb::task_arena arena(arena_slots(threads));
    const int grain = std::max(1, count / (8 * arena_slots(threads)));
    arena.execute([&] {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range<int>(0, count, static_cast<std::size_t>(grain)),
            [&](const oneapi::tbb::blocked_range<int>& range) {
                body(range.begin(), range.end());
            });
    });
}

}  // namespace irt::cells
