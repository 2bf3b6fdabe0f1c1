// SPDX-License-Identifier: Apache-2.0
// From what Scene::apply found to differ to what the cells have to ask.
#pragma once

#include <vector>

#include "irt/history/voxel_grid.h"
#include "irt/scene/scene.h"
#include "irt/trace/intersector.h"
#include "irt/update/plan.h"

namespace irt::update {

/// Boxes of what `applied` changed, as it is in the trees that have not taken it up yet; what has
/// none left out.
std::vector<trace::Box> former_boxes(const trace::Intersector& intersector,
                                     const AppliedChanges& applied);

/// `old_boxes` (of the objects whose geometry changed) and `old_lights` are those from before
/// `applied`; scene and trees are as after.
Plan make_plan(const Scene& scene, const trace::Intersector& intersector,
               const history::VoxelGrid& grid, const AppliedChanges& applied,
               const std::vector<trace::Box>& old_boxes, const std::vector<LightSlot>& old_lights);

}  // namespace irt::update
