// SPDX-License-Identifier: Apache-2.0
#include "irt/update/reach.h"

#include <algorithm>

#include "irt/mutant.h"
#include "irt/update/footprint.h"

namespace irt::update {

namespace {

/// Boxes of the reach. Every distinct path is tested once only, so that they may be many.
constexpr std::size_t most_boxes = 512;

bool changes(const Foreseen& foreseen, const Scene& scene, std::uint32_t slot,
             const std::vector<std::uint32_t>& materials) {
    return foreseen.object_changes(scene, slot) ||
           std::any_of(materials.begin(), materials.end(), [&](std::uint32_t material) {
               return foreseen.material_changes(scene.materials()[material].name);
           });
}

}  // namespace

Reach make_reach(const Foreseen& foreseen, const Scene& scene, const history::VoxelGrid& grid) {
    history::VoxelSet voxels;
    trace::Box bounds{V3d(0), V3d(history::grid_side)};
    for (const ObjectSlot& object : scene.all_objects()) {
        if (!object.live) continue;
        const std::vector<std::uint32_t> slots =
            object.array ? scene.entry_slots(object) : std::vector{object.slot};
        const std::vector<std::uint32_t> own =
            object.array ? std::vector<std::uint32_t>() : materials_of(object);
        for (const std::uint32_t slot : slots)
            if (changes(foreseen, scene, slot,
                        object.array ? scene.prototype(slot)->materials : own))
                add_object(scene, slot, grid, voxels, bounds);
    }
    for (const auto& [path, boxes] : foreseen.boxes())
        for (const trace::Box& box : boxes)
            if (!mutated(Mutant::future_ignored))
                add_box({box.lower - scene.render_origin(), box.upper - scene.render_origin()},
                        grid, voxels);
    Reach reach{&foreseen, {}};
    reach.regions.add(voxels, bounds, most_boxes);
    return reach;
}

}  // namespace irt::update
