// SPDX-License-Identifier: Apache-2.0
#include "delegate/settings.h"

#include <cmath>

#include "pxr/base/gf/vec3d.h"
#include "pxr/base/tf/diagnostic.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_DEFINE_PUBLIC_TOKENS(HdIrtSettingTokens, HDIRT_SETTING_TOKENS);

namespace {

constexpr int defaultBudget = 4096;  // MiB

/// A number in [low, high]; else the default, with a warning.
template <class T>
T Number(const HdRenderDelegate& delegate, const TfToken& key, T otherwise, T low, T high) {
    const VtValue value = delegate.GetRenderSetting(key);
    if (value.IsEmpty()) return otherwise;
    const VtValue cast = VtValue::Cast<T>(value);
    const bool fits = !cast.IsEmpty() && cast.template UncheckedGet<T>() >= low &&
                      cast.template UncheckedGet<T>() <= high;
    if (fits) return cast.template UncheckedGet<T>();
    TF_WARN("The render setting %s is out of range: expected a number from %g to %g; %g is used",
            key.GetText(), static_cast<double>(low), static_cast<double>(high),
            static_cast<double>(otherwise));
    return otherwise;
}

}  // namespace

HdRenderSettingDescriptorList HdIrtSettingDescriptors() {
    const HdIrtSettings d;
    return {
        {"Samples per pixel", HdRenderSettingsTokens->convergedSamplesPerPixel, VtValue(d.samples)},
        {"Max bounces", HdIrtSettingTokens->maxDepth, VtValue(d.max_depth)},
        {"Tolerance (least share of a pixel)", HdIrtSettingTokens->throughputCutoff,
         VtValue(static_cast<float>(d.throughput_cutoff))},
        {"Roughest mirror", HdIrtSettingTokens->mirrorRoughness,
         VtValue(static_cast<float>(d.mirror_roughness))},
        {"Keep history", HdIrtSettingTokens->history, VtValue(d.history)},
        {"History budget (MiB)", HdIrtSettingTokens->historyBudget, VtValue(defaultBudget)},
        {"Recent views kept", HdIrtSettingTokens->recentViews, VtValue(d.recent_views)},
        {"Threads (0: all)", HdIrtSettingTokens->threads, VtValue(d.threads)},
        {"Light at the camera where there is none", HdIrtSettingTokens->cameraLight,
         VtValue(d.camera_light)},
    };
}

HdIrtSettings HdIrtReadSettings(const HdRenderDelegate& delegate) {
    const HdIrtSettings d;
    HdIrtSettings s;
    s.samples =
        Number(delegate, HdRenderSettingsTokens->convergedSamplesPerPixel, d.samples, 1, 4096);
    s.max_depth = Number(delegate, HdIrtSettingTokens->maxDepth, d.max_depth, 0, 64);
    // The descriptors' single precision holds the defaults' nearest numbers.
    const auto number = [&](const TfToken& key, double otherwise) {
        const double value = Number(delegate, key, otherwise, 0.0, 1.0);
        return static_cast<float>(value) == static_cast<float>(otherwise) ? otherwise : value;
    };
    s.throughput_cutoff = number(HdIrtSettingTokens->throughputCutoff, d.throughput_cutoff);
    s.mirror_roughness = number(HdIrtSettingTokens->mirrorRoughness, d.mirror_roughness);
    s.history = delegate.GetRenderSetting<bool>(HdIrtSettingTokens->history, d.history);
    s.history_budget = static_cast<std::size_t>(Number(delegate, HdIrtSettingTokens->historyBudget,
                                                       defaultBudget, 0, 1 << 24))
                       << 20;
    s.recent_views = Number(delegate, HdIrtSettingTokens->recentViews, d.recent_views, 0, 64);
    s.threads = Number(delegate, HdIrtSettingTokens->threads, d.threads, 0, 4096);
    s.camera_light =
        delegate.GetRenderSetting<bool>(HdIrtSettingTokens->cameraLight, d.camera_light);
    const VtValue origin = delegate.GetRenderSetting(HdIrtSettingTokens->renderOrigin);
    if (origin.IsHolding<GfVec3d>()) {
        const auto& o = origin.UncheckedGet<GfVec3d>();
        if (std::isfinite(o[0]) && std::isfinite(o[1]) && std::isfinite(o[2]))
            s.render_origin = irt::V3d(o[0], o[1], o[2]);
    }
    return s;
}

PXR_NAMESPACE_CLOSE_SCOPE
