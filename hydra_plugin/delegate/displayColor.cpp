// SPDX-License-Identifier: Apache-2.0
#include "delegate/displayColor.h"

#include <algorithm>
#include <cmath>

#include "delegate/primvars.h"
#include "pxr/base/tf/diagnostic.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// A node that reads a primvar, `fallback` where there is none.
irt::ShadeNode Reads(const std::string& primvar, const std::array<float, 4>& fallback) {
    irt::ShadeNode node;
    node.op = irt::Op::Primvar;
    node.primvar = primvar;
    node.constants[0] = fallback;
    return node;
}

/// The first element.
const float* First(const irt::Primvar& primvar) {
    const std::size_t index =
        primvar.indices.empty() ? 0 : static_cast<std::size_t>(primvar.indices[0]);
    return primvar.values.data() + index * static_cast<std::size_t>(primvar.width);
}

bool OutOfRange(const SdfPath& id, const irt::Primvar& primvar, int width, float most) {
    const bool fits =
        primvar.width == width && std::all_of(First(primvar), First(primvar) + width,
                                              [&](float v) { return v >= 0 && v <= most; });
    if (!fits)
        TF_WARN("<%s>: %s is of the wrong type or out of range; its default is rendered",
                id.GetText(), primvar.name.c_str());
    return !fits;
}

/// Whether the shape reads it point by point.
bool Varies(const irt::Primvar& primvar) {
    return primvar.interpolation != irt::Interpolation::Constant && HdIrtElements(primvar) > 1;
}

}  // namespace

std::optional<irt::Material> HdIrtDisplayMaterial(HdSceneDelegate& delegate, const SdfPath& id) {
    const auto color = HdIrtReadPrimvar(delegate, id, "displayColor");
    const auto opacity = HdIrtReadPrimvar(delegate, id, "displayOpacity");
    if (!color && !opacity) return std::nullopt;
    irt::Material material;
    const auto connect = [&](irt::SurfaceInput input, irt::ShadeNode node, std::uint8_t channel) {
        material.nodes.push_back(std::move(node));
        material.connected[static_cast<std::size_t>(input)] = {
            static_cast<std::int32_t>(material.nodes.size()) - 1, channel};
    };
    if (color && !color->values.empty()) {
        const irt::V3f grey = material.diffuse_color;
        if (Varies(*color))
            connect(irt::SurfaceInput::DiffuseColor,
                    Reads("displayColor", {grey.x, grey.y, grey.z, 1}), irt::Connection::rgb);
        else if (!OutOfRange(id, *color, 3, HUGE_VALF))
            material.diffuse_color = {First(*color)[0], First(*color)[1], First(*color)[2]};
    }
    if (opacity && !opacity->values.empty()) {
        if (Varies(*opacity))
            connect(irt::SurfaceInput::Opacity, Reads("displayOpacity", {1, 1, 1, 1}), 0);
        else if (!OutOfRange(id, *opacity, 1, 1))
            material.opacity = *First(*opacity);
    }
    return material;
}

PXR_NAMESPACE_CLOSE_SCOPE
