// SPDX-License-Identifier: Apache-2.0
// A subdivision mesh drawn as its control cage.
#pragma once

#include "irt/scene/subdivide.h"

namespace irt {

/// What Subdivider::refine gives at level 0; throws as it does.
Mesh control_cage(const Mesh& cage, const Subdivision& rules);

}  // namespace irt
