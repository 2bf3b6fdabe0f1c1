// SPDX-License-Identifier: Apache-2.0
// What a user may choose (docs/hydra.md).
#pragma once

#include <cstddef>
#include <optional>

#include "irt/math/vec.h"
#include "pxr/base/tf/staticTokens.h"
#include "pxr/imaging/hd/renderDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

#define HDIRT_SETTING_TOKENS                                                                   \
    ((maxDepth, "irt:maxDepth"))((throughputCutoff, "irt:throughputCutoff"))(                  \
        (mirrorRoughness, "irt:mirrorRoughness"))((historyBudget, "irt:historyBudget"))(       \
        (recentViews, "irt:recentViews"))((threads, "irt:threads"))((history, "irt:history"))( \
        (cameraLight, "irt:cameraLight"))((renderOrigin, "irt:renderOrigin"))
TF_DECLARE_PUBLIC_TOKENS(HdIrtSettingTokens, HDIRT_SETTING_TOKENS);

struct HdIrtSettings {
    int samples = 1, max_depth = 8;
    double throughput_cutoff = 0x1p-10, mirror_roughness = 0.1;
    bool history = true;
    std::size_t history_budget = std::size_t{4} << 30;  ///< bytes
    int recent_views = 2;  ///< whose histories are kept, beside those that are shown
    int threads = 0;       ///< 0: all of the machine
    bool camera_light = true;
    std::optional<irt::V3d> render_origin;  ///< empty: the first camera's place
};

/// What hosts list.
HdRenderSettingDescriptorList HdIrtSettingDescriptors();
/// As `delegate` has them; what is out of range is warned of, and its default taken.
HdIrtSettings HdIrtReadSettings(const HdRenderDelegate& delegate);

PXR_NAMESPACE_CLOSE_SCOPE
