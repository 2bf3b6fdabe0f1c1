// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "irt/scene/material.h"
#include "pxr/imaging/hd/sceneDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

/// The material of what has none: of displayColor and displayOpacity, in every interpolation.
std::optional<irt::Material> HdIrtDisplayMaterial(HdSceneDelegate& delegate, const SdfPath& id);

PXR_NAMESPACE_CLOSE_SCOPE
