// SPDX-License-Identifier: Apache-2.0
// What holds of a history after every update, checked entry by entry against the scene. For tests:
// it asks as much as a full trace and is called by nothing else.
#pragma once

#include <string>

#include "irt/history/path_table.h"
#include "irt/history/ray_trees.h"
#include "irt/shade/shading.h"
#include "irt/trace/intersector.h"

namespace irt::history {

/// Checks the history of one cell: links and free lists, paths, visible points, what lies behind
/// them, shadow records, masks, intensities and prices. Scene, trees and shading are those of its
/// last update. Throws std::logic_error, beginning with `where` and naming the node, on the first
/// invariant that is broken.
void check_invariants(const RayTrees& trees, const PathTable& table, const shade::Shading& shading,
                      const trace::Intersector& intersector, const std::string& where);

}  // namespace irt::history
