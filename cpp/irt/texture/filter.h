// SPDX-License-Identifier: Apache-2.0
// Looking a texture up, filtered by the footprint alone (DESIGN 3, rule 12).
#pragma once

#include <optional>

#include "irt/texture/texture.h"

namespace irt::texture {

/// Probes along the major axis of a footprint are at most so many; a longer one is looked up in
/// coarser levels.
inline constexpr int max_probes = 16;

using Texel = std::array<double, 4>;

/// The mean over the ellipse whose axes `dx` and `dy` span at `st` (whole axes: what a pixel
/// covers, both zero for a point). Its true axes follow by the singular values of the two; along
/// the longer one stand as many trilinear probes as it is times longer than the other, or than a
/// texel. Linear light, rendering space. Empty where a UDIM texture has no tile at `st`, or `st` is
/// not finite.
[[nodiscard]] std::optional<Texel> look_up(const Texture& texture, Wrap wrap_s, Wrap wrap_t,
                                           const V2d& st, const V2d& dx, const V2d& dy);

}  // namespace irt::texture
