// SPDX-License-Identifier: Apache-2.0
// The coarser levels of an image.
#pragma once

#include "irt/texture/texture.h"

namespace irt::texture {

/// The image at half the size, rounded down, at least 1: every texel the mean, in linear light, of
/// the area that it covers, so that the mean of the image stays. Rounded to `format`.
Image halved(const Image& image, int channels, TexelFormat format, Transfer transfer);

}  // namespace irt::texture
