// SPDX-License-Identifier: Apache-2.0
#include "irt/cells/cells.h"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <numeric>

#include "irt/math/float_state.h"

namespace irt::cells {

namespace {

/// TBB makes no more threads than the machine has, and complains where more are asked for.
int arena_slots(int threads) {
    return std::min(thread_count(threads), oneapi::tbb::info::default_concurrency());
}

/// The arena of that many slots. It is made once: small updates take less time than making one.
oneapi::tbb::task_arena& arena(int slots) {
    static std::mutex making;
    static std::map<int, oneapi::tbb::task_arena> arenas;
    const std::lock_guard lock(making);
    return arenas.try_emplace(slots, slots).first->second;
}

}  // namespace

CellOrder natural_order() {
    CellOrder order(cell_count);
    std::iota(order.begin(), order.end(), 0);
    return order;
}

int thread_count(int threads) {
    return threads > 0 ? threads : oneapi::tbb::info::default_concurrency();
}

void for_each_task(int threads, int count, const std::function<void(int task)>& body) {
    arena(arena_slots(threads)).execute([&] {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range<int>(0, count, 1),
            [&](const oneapi::tbb::blocked_range<int>& range) {
                const FloatState ieee;
                for (int task = range.begin(); task < range.end(); ++task) body(task);
            },
            oneapi::tbb::simple_partitioner());
    });
}

void for_each_group(int threads, int groups, const CellOrder& order,
                    const std::function<void(CellGroup group)>& body) {
    const auto cells = static_cast<int>(order.size());
    const int count = std::clamp(groups, 1, cells);
    const auto first_of = [=](int group) {
        return static_cast<std::size_t>(group * cells / count);
    };
    for_each_task(threads, count, [&](int g) {
        body(CellGroup(order).subspan(first_of(g), first_of(g + 1) - first_of(g)));
    });
}

}  // namespace irt::cells
