// SPDX-License-Identifier: Apache-2.0
// The voxels an object's surface occupies: what a changed object flags (paper, section 2.2).
#pragma once

#include "irt/history/voxel_grid.h"
#include "irt/scene/scene.h"

namespace irt::update {

/// Adds the voxels that `box` (render space) meets.
void add_box(const trace::Box& box, const history::VoxelGrid& grid, history::VoxelSet& voxels);
/// Adds the voxels that a shape's surface meets; widens `bounds` by its own, in voxels. Of an
/// instance that lies within few voxels, those that its box meets.
void add_surface(const Surface& surface, const history::VoxelGrid& grid, history::VoxelSet& voxels,
                 trace::Box& bounds);
void add_instance(const CompiledPrototype& prototype, const M44d& render_from_prototype,
                  const history::VoxelGrid& grid, history::VoxelSet& voxels, trace::Box& bounds);
/// Likewise of a live object of the scene.
void add_object(const Scene& scene, std::uint32_t slot, const history::VoxelGrid& grid,
                history::VoxelSet& voxels, trace::Box& bounds);

/// Collects the voxels that objects' surfaces meet, each enlarged by VoxelGrid::dilation: triangles
/// clipped to voxels; of a quadric, ball or segment, the voxels its oriented box meets. A superset,
/// so that the path of every ray that hits an object meets the regions (DESIGN 3, rule 8).
class Footprints {
  public:
    /// `objects`: how many will be added. While they are few each has its own boxes, cut to its own
    /// bounds.
    Footprints(const history::VoxelGrid& grid, std::size_t objects);

    /// A live object of the scene; nothing if it is dead.
    void add(const Scene& scene, std::uint32_t slot);
    /// What there was.
    void add(const ObjectSlot& previous);
    void add(const FormerEntries& former);
    [[nodiscard]] history::Regions regions() const;

  private:
    static constexpr std::size_t few = 16;

    template <class Add>
    void add_one(Add&& add);

    const history::VoxelGrid& grid_;
    bool apart_;
    history::Regions regions_;
    history::VoxelSet together_;
    trace::Box bounds_;  ///< in voxels, of `together_`
};

}  // namespace irt::update
