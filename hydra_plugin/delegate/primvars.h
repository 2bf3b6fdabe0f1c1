// SPDX-License-Identifier: Apache-2.0
// Hydra's primvars as the core's.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>

#include "irt/scene/records.h"
#include "pxr/imaging/hd/sceneDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

/// How many elements an interpolation asks for; 0: the shape does not take it.
using HdIrtElementCount = std::function<std::size_t(irt::Interpolation)>;

irt::Interpolation HdIrtInterpolation(HdInterpolation interpolation);

/// A primvar whatever its name, and empty where there is none of numbers, or one that is broken,
/// which is warned of.
std::optional<irt::Primvar> HdIrtReadPrimvar(HdSceneDelegate& delegate, const SdfPath& id,
                                             const std::string& name);

/// Those of `wanted` that fit the shape, by name; the others are warned of.
irt::Primvars HdIrtReadPrimvars(HdSceneDelegate& delegate, const SdfPath& id,
                                const std::set<std::string>& wanted,
                                const HdIrtElementCount& count);

/// Of shapes without vertices: those of one element, as constant ones.
irt::Primvars HdIrtConstantPrimvars(HdSceneDelegate& delegate, const SdfPath& id,
                                    const std::set<std::string>& wanted);

/// How many elements there are.
std::size_t HdIrtElements(const irt::Primvar& primvar);

/// The value of `name`, computed where an ext computation gives it (skinned points).
VtValue HdIrtComputedPrimvar(HdSceneDelegate& delegate, const SdfPath& id, const TfToken& name);

PXR_NAMESPACE_CLOSE_SCOPE
