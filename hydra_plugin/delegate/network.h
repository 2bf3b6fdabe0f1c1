// SPDX-License-Identifier: Apache-2.0
// Networks of UsdPreviewSurface's nodes to the core's shading graph: UsdUVTexture,
// UsdPrimvarReader_* and UsdTransform2d, by UsdPreviewSurface's specification 2.6.
#pragma once

#include <optional>

#include "delegate/textures.h"
#include "irt/scene/material.h"
#include "pxr/imaging/hd/material.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Empty, and warned of, where there is no surface that is rendered.
std::optional<irt::Material> HdIrtSurface(const HdMaterialNetworkMap& networks, const SdfPath& id,
                                          HdIrtTextures& textures);

PXR_NAMESPACE_CLOSE_SCOPE
