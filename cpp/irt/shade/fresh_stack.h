// SPDX-License-Identifier: Apache-2.0
// Deep ray trees are walked by recursion, which threads of a host may have little stack for.
#pragma once

#include <future>
#include <utility>

#include "irt/math/float_state.h"

namespace irt::shade {

/// Levels of a ray tree that one thread's stack must hold: about half a megabyte, at some 1 KB a
/// level.
inline constexpr int levels_a_stack = 512;

/// Runs `body`, which traces a ray of `depth` and all below it; on a thread of its own where
/// another such number of levels begins.
template <class Body>
auto with_stack_for(int depth, Body&& body) {
    if (depth == 0 || depth % levels_a_stack != 0) return body();
    return std::async(std::launch::async,
                      [&] {
                          const FloatState ieee;
                          return body();
                      })
        .get();
}

}  // namespace irt::shade
