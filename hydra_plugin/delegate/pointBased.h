// SPDX-License-Identifier: Apache-2.0
// What points and curves share.
#pragma once

#include <optional>
#include <vector>

#include "delegate/primvars.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Diameters, 1 where there are none.
struct HdIrtWidths {
    std::vector<float> values;
    irt::Interpolation interpolation = irt::Interpolation::Constant;
};

/// Empty, and warned of, where there are none that can be drawn.
std::optional<std::vector<irt::V3f>> HdIrtReadPoints(HdSceneDelegate& delegate, const SdfPath& id);
std::optional<HdIrtWidths> HdIrtReadWidths(HdSceneDelegate& delegate, const SdfPath& id,
                                           const HdIrtElementCount& count);

PXR_NAMESPACE_CLOSE_SCOPE
