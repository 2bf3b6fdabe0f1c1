// SPDX-License-Identifier: Apache-2.0
// What of a surface a ray's cone covers (Akenine-Moeller, Crassin, Boksansky, Belcour, Panteleev,
// Wright, "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1), 2021).
#pragma once

#include "irt/graph/evaluate.h"

namespace irt::shade {

/// Cosines between ray and normal are taken to be at least this: the footprint is at most so many
/// times longer than wide.
inline constexpr double least_cosine = 1.0 / 1024;

/// Two vectors in the plane of `normal` (unit): the axes of the ellipse that a cone `width` wide,
/// around `direction` (unit), cuts out of it. What they span, a sample covers.
struct FootprintAxes {
    V3d along, across;
};
[[nodiscard]] FootprintAxes footprint_axes(const V3d& direction, const V3d& normal, double width);

/// Sets how the weights of the triangle at `site` change along those axes (render space); nothing
/// where there is no triangle, for no primvar varies there.
void set_footprint(const V3d& direction, const V3d& normal, double width,
                   const M44d& render_from_trace, graph::Site& site);

}  // namespace irt::shade
