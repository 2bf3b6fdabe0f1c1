// SPDX-License-Identifier: Apache-2.0
// Hydra's cameras as the core's.
#pragma once

#include <optional>

#include "irt/scene/records.h"
#include "pxr/base/gf/rect2i.h"
#include "pxr/imaging/hd/renderPassState.h"

PXR_NAMESPACE_OPEN_SCOPE

/// What a render pass shows.
struct HdIrtSight {
    irt::Camera camera;
    int frame_width = 0, frame_height = 0;
    int x = 0, y = 0, width = 0, height = 0;  ///< of the film, from the frame's upper left
    float exposure = 1;
};

/// Empty where nothing can be seen: an image without pixels, a camera that is none.
std::optional<HdIrtSight> HdIrtSightOf(const HdRenderPassState& state);

PXR_NAMESPACE_CLOSE_SCOPE
