// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "delegate/scene.h"
#include "delegate/session.h"
#include "delegate/textures.h"
#include "pxr/imaging/hd/renderDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

/// What prims fill, and what renders it.
class HdIrtRenderParam final : public HdRenderParam {
  public:
    HdIrtScene scene;
    HdIrtTextures textures;
    HdIrtSession session{scene};
};

PXR_NAMESPACE_CLOSE_SCOPE
