// SPDX-License-Identifier: Apache-2.0
// A texture's finest texels as colours, for sums over all of it.
#pragma once

#include <vector>

#include "irt/texture/texture.h"

namespace irt::texture {

/// The colours of one row of the finest level of `tile`, the top row being 0: linear light,
/// rendering space.
[[nodiscard]] std::vector<V3d> row_of(const Texture& texture, const Tile& tile, int row);

/// The mean colour of all texels; of a UDIM texture, of all its tiles alike.
[[nodiscard]] V3d mean(const Texture& texture);

}  // namespace irt::texture
