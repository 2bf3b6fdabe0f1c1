// SPDX-License-Identifier: Apache-2.0
// What a light's shadows leave out or weaken: UsdLux's shadow linking and shadow falloff.
#pragma once

#include <cstdint>
#include <vector>

#include "irt/trace/ray.h"

namespace irt::trace {

struct ShadowRule {
    /// By index into Scene::all_objects(): those that cast none; may end before them.
    std::vector<bool> shadowless;
    /// Shadows fade from `distance - falloff` on, between occluder and lit point, to none at
    /// `distance`; falloff 0: they do not. Render-space units.
    double distance = 0, falloff = 0, gamma = 1;

    [[nodiscard]] bool casts(std::uint32_t object) const {
        return object >= shadowless.size() || !shadowless[object];
    }
    /// What is left of an occluder's `depth` at a distance from the lit point.
    [[nodiscard]] OpticalDepth faded(const OpticalDepth& depth, double from_point) const;
};

}  // namespace irt::trace
