// SPDX-License-Identifier: Apache-2.0
#include "delegate/pointBased.h"

#include <algorithm>
#include <cmath>

#include "delegate/convert.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

std::optional<std::vector<irt::V3f>> HdIrtReadPoints(HdSceneDelegate& delegate, const SdfPath& id) {
    const VtValue value = HdIrtComputedPrimvar(delegate, id, HdTokens->points);
    if (!value.IsHolding<VtVec3fArray>() || value.UncheckedGet<VtVec3fArray>().empty())
        return std::nullopt;
    const auto& points = value.UncheckedGet<VtVec3fArray>();
    const bool finite = std::all_of(points.cbegin(), points.cend(), [](const GfVec3f& p) {
        return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    });
    if (finite) return HdIrtVectors(points);
    TF_WARN("<%s>: its points hold a NaN or an infinity; expected finite numbers; it is not drawn",
            id.GetText());
    return std::nullopt;
}

std::optional<HdIrtWidths> HdIrtReadWidths(HdSceneDelegate& delegate, const SdfPath& id,
                                           const HdIrtElementCount& count) {
    const std::optional<irt::Primvar> primvar =
        HdIrtReadPrimvar(delegate, id, HdTokens->widths.GetString());
    if (!primvar || primvar->values.empty()) return HdIrtWidths{{1.0f}};
    HdIrtWidths widths;
    widths.interpolation = primvar->interpolation;
    if (primvar->indices.empty())
        widths.values = primvar->values;
    else
        for (const std::int32_t index : primvar->indices)
            widths.values.push_back(primvar->values[static_cast<std::size_t>(index)]);
    const std::size_t expected = count(widths.interpolation);
    const bool positive =
        std::all_of(widths.values.begin(), widths.values.end(), [](float w) { return w >= 0; });
    if (primvar->width != 1 || !positive ||
        (widths.values.size() != expected && widths.values.size() != 1)) {
        TF_WARN(
            "<%s>: there are %zu widths, some of them below 0 or no numbers; expected %zu from "
            "0; it is not drawn",
            id.GetText(), widths.values.size(), expected);
        return std::nullopt;
    }
    if (widths.values.size() != expected) widths.interpolation = irt::Interpolation::Constant;
    if (std::all_of(widths.values.begin(), widths.values.end(), [](float w) { return w == 0; }))
        return std::nullopt;
    return widths;
}

PXR_NAMESPACE_CLOSE_SCOPE
