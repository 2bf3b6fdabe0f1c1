// SPDX-License-Identifier: Apache-2.0
// What an update changes, as the cells want to ask it. Made once an update, read by all cells.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "irt/scene/scene.h"
#include "irt/trace/box.h"

namespace irt::update {

struct Plan {
    /// By object slot; the paper's change flags on the object database.
    std::vector<bool> geometry_changed;  ///< C: added, removed, moved or reshaped
    std::vector<bool> rebound;           ///< bound to another material
    std::vector<bool> tint_changed;      ///< stops another share of light than before
    /// Some object that did not move stops another share of light than before.
    bool still_tint_changed = false;
    std::uint64_t material_mask = 0;   ///< bits of the changed materials, slots folded modulo 64
    std::vector<trace::Box> arrivals;  ///< where C, and what changed its tint, now are
    std::vector<trace::Box> regions;   ///< those, and where C was
    /// By light: its place before, if it casts the same rays as then.
    std::vector<std::optional<std::size_t>> kept_lights;
    bool lights_moved = false;   ///< some light is new or moved, and with it all its shadow rays
    bool lights_differ = false;  ///< any change of any light, energy included

    [[nodiscard]] bool flags_objects() const {
        return !regions.empty() || material_mask != 0 || !rebound.empty();
    }
};

}  // namespace irt::update
