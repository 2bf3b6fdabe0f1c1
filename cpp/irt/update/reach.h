// SPDX-License-Identifier: Apache-2.0
// Where, in a shot that is known beforehand, anything can ever change.
#pragma once

#include "irt/history/voxel_grid.h"
#include "irt/scene/foreseen.h"
#include "irt/scene/scene.h"

namespace irt::update {

/// What recording asks of a shot that is known beforehand. Rays that meet none of `regions` will
/// never change, but by moved lights.
struct Reach {
    const Foreseen* foreseen;
    history::Regions regions;
};

/// The voxels of everything in `scene` whose shape, place, binding or material will change, and of
/// all places that it will be in.
Reach make_reach(const Foreseen& foreseen, const Scene& scene, const history::VoxelGrid& grid);

}  // namespace irt::update
