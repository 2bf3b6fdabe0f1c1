// SPDX-License-Identifier: Apache-2.0
// What an update changes, as the cells want to ask it. Made once an update, read by all cells.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "irt/history/voxel_grid.h"
#include "irt/scene/scene.h"
#include "irt/trace/box.h"

namespace irt::update {

/// Boxes, tested one by one while they are few, else by the one box around them.
class Boxes {
  public:
    static constexpr std::size_t few = 8;

    /// Adds `box`, enlarged by `slack` on every side.
    void add(const trace::Box& box, double slack);
    /// Whether origin + t direction, t from 0 to `t_end`, may meet one of them.
    [[nodiscard]] bool may_meet(const V3d& origin, const V3d& direction, double t_end) const;

  private:
    std::vector<trace::Box> boxes_;
    bool merged_ = false;
};

struct Plan {
    /// By object slot; the paper's change flags on the object database.
    std::vector<bool> geometry_changed;  ///< C: added, removed, moved or reshaped
    std::vector<bool> rebound;           ///< bound to another material
    std::vector<bool> tint_changed;      ///< stops another share of light than before
    std::vector<bool> material_changed;  ///< by material slot
    /// Some object that did not move stops another share of light than before.
    bool still_tint_changed = false;
    /// Bits of the changed materials and of those that rebound objects had, slots folded modulo 64.
    std::uint64_t material_mask = 0;
    /// Some object that changed let light through before: shadow rays do not name it.
    bool tint_departed = false;
    bool geometry_differs = false;  ///< C is not empty
    /// Where C now is; where C was; where C, and what changed its tint, now are. Enlarged by
    /// Intersector::pad, so that a segment found by rounding other than its ray's own may stand for
    /// the ray.
    Boxes arrivals, departures, shadowing;
    history::Regions regions;  ///< the voxels of both: change flags on voxels
    /// By light: its place before, if it casts the same rays as then.
    std::vector<std::optional<std::size_t>> kept_lights;
    /// By light: it casts the same rays, and surfaces respond to it otherwise.
    std::vector<bool> reshaped_lights;
    /// Of each light that changed its place among the scene's, if it is there.
    std::vector<std::optional<std::size_t>> changed_lights;
    bool lights_reshaped = false;
    bool lights_moved = false;   ///< some light is new or moved, and with it all its shadow rays
    bool skies_differ = false;   ///< rays that meet nothing see something else
    bool lights_differ = false;  ///< any change of any light, energy included
};

}  // namespace irt::update
