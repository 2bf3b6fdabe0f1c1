// SPDX-License-Identifier: Apache-2.0
// From what Scene::apply found to differ to what the cells have to ask.
#pragma once

#include <vector>

#include "irt/scene/scene.h"
#include "irt/trace/intersector.h"
#include "irt/update/plan.h"

namespace irt::update {

/// Boxes of the objects in `slots`, as they are in the trees now; objects without one left out.
std::vector<trace::Box> footprints(const trace::Intersector& intersector,
                                   const std::vector<std::uint32_t>& slots);

/// `old_footprints` and `old_lights` are those from before `applied`; scene and trees are as after.
Plan make_plan(const Scene& scene, const trace::Intersector& intersector,
               const AppliedChanges& applied, std::vector<trace::Box> old_footprints,
               const std::vector<LightSlot>& old_lights);

}  // namespace irt::update
