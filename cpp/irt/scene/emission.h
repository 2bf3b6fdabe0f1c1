// SPDX-License-Identifier: Apache-2.0
// How a delta light's energy leaves it, by direction: the far field of the UsdLux light that it
// stands for, and UsdLux's shaping.
#pragma once

#include "irt/scene/records.h"

namespace irt {

/// Share of the light's energy that leaves in `direction` (unit, world orientation), by channel: 1
/// all around where nothing shapes it. `squared`: the square of the distance to the lit point, of
/// lights that have a place. Pure function of all three.
V3d emission(const Light& light, const V3d& direction, double squared);

}  // namespace irt
