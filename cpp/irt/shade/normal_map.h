// SPDX-License-Identifier: Apache-2.0
// Normals given in tangent space.
#pragma once

#include "irt/graph/evaluate.h"
#include "irt/trace/intersector.h"

namespace irt::shade {

/// The unit shading normal, out of the front side, that `tangent_space` (of any length) stands for
/// at `point`: x along growing s, y along growing t, z along the shading normal. The frame is that
/// of the triangle's (s, t) made perpendicular to the shading normal; the second axis is
/// perpendicular to the first, on the side that the sign of the area in (s, t) says, as in
/// MikkTSpace. (s, t) is the primvar that the normal's graph reads first, otherwise "st". Where
/// there is no frame (no such primvar, no area), or `tangent_space` has no direction, the shading
/// normal stays.
[[nodiscard]] V3d mapped_normal(const Material& material, const graph::Site& site,
                                const M44d& render_from_trace, const trace::SurfacePoint& point,
                                const V3d& tangent_space);

}  // namespace irt::shade
