// SPDX-License-Identifier: Apache-2.0
// A stage of every kind of prim, and edits of it.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "pxr/usd/usd/stage.h"

PXR_NAMESPACE_OPEN_SCOPE

UsdStageRefPtr MakeStage();

/// An edit of a stage that MakeStage made, by chance.
struct Edit {
    std::string name;
    std::function<void(const UsdStageRefPtr&, std::mt19937&)> apply;
};
const std::vector<Edit>& Edits();
/// Edits after which some prims cannot be drawn.
const std::vector<Edit>& InvalidEdits();

/// The same layers, opened anew.
UsdStageRefPtr CopyOf(const UsdStageRefPtr& stage);

PXR_NAMESPACE_CLOSE_SCOPE
