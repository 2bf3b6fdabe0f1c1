// SPDX-License-Identifier: Apache-2.0
#include "delegate/network.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "delegate/graphBuilder.h"
#include "pxr/base/tf/diagnostic.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// An input of UsdPreviewSurface and where it goes.
struct Input {
    const char* name;
    irt::SurfaceInput input;
    bool vector;
    float low, high;
    float* (*field)(irt::Material&);
};

template <auto Member>
float* Field(irt::Material& material) {
    if constexpr (std::is_same_v<std::remove_reference_t<decltype(material.*Member)>, irt::V3f>)
        return &(material.*Member).x;
    else
        return &(material.*Member);
}

using M = irt::Material;
using S = irt::SurfaceInput;
const Input inputs[] = {
    {"diffuseColor", S::DiffuseColor, true, 0, HUGE_VALF, Field<&M::diffuse_color>},
    {"emissiveColor", S::EmissiveColor, true, 0, HUGE_VALF, Field<&M::emissive_color>},
    {"specularColor", S::SpecularColor, true, 0, HUGE_VALF, Field<&M::specular_color>},
    {"metallic", S::Metallic, false, 0, 1, Field<&M::metallic>},
    {"roughness", S::Roughness, false, 0, 1, Field<&M::roughness>},
    {"clearcoat", S::Clearcoat, false, 0, 1, Field<&M::clearcoat>},
    {"clearcoatRoughness", S::ClearcoatRoughness, false, 0, 1, Field<&M::clearcoat_roughness>},
    {"opacity", S::Opacity, false, 0, 1, Field<&M::opacity>},
    {"opacityThreshold", S::OpacityThreshold, false, 0, 1, Field<&M::opacity_threshold>},
    {"ior", S::Ior, false, 1e-3f, HUGE_VALF, Field<&M::ior>},
    {"normal", S::Normal, true, -HUGE_VALF, HUGE_VALF, Field<&M::normal>}};

/// Takes over what fits, clamped, and leaves the default where nothing does.
void SetConstant(const VtValue& value, const Input& input, const SdfPath& id, float* field) {
    HdIrtSlot slot;
    const int width = input.vector ? 3 : 1;
    const bool fits = HdIrtConstant(value, slot) == width;
    if (!fits || !std::all_of(slot.begin(), slot.begin() + width,
                              [](float v) { return std::isfinite(v); })) {
        TF_WARN("<%s>: its %s is no finite value of the input's type; the default is rendered",
                id.GetText(), input.name);
        return;
    }
    for (int c = 0; c < width; ++c)
        field[c] = std::clamp(slot[static_cast<std::size_t>(c)], input.low, input.high);
}

}  // namespace

std::optional<irt::Material> HdIrtSurface(const HdMaterialNetworkMap& networks, const SdfPath& id,
                                          HdIrtTextures& textures) {
    const HdMaterialNetwork2 network = HdConvertToHdMaterialNetwork2(networks);
    const auto terminal = network.terminals.find(HdMaterialTerminalTokens->surface);
    if (terminal == network.terminals.end()) return std::nullopt;
    const auto surface = network.nodes.find(terminal->second.upstreamNode);
    if (surface == network.nodes.end()) return std::nullopt;
    const HdMaterialNode2& shader = surface->second;
    if (shader.nodeTypeId != "UsdPreviewSurface") {
        TF_WARN("<%s>: the surface shader %s is not rendered; displayColor is instead",
                id.GetText(), shader.nodeTypeId.GetText());
        return std::nullopt;
    }
    irt::Material material;
    HdIrtGraphBuilder builder(network, textures);
    const auto workflow = shader.parameters.find(TfToken("useSpecularWorkflow"));
    if (workflow != shader.parameters.end())
        material.use_specular_workflow =
            VtValue::Cast<int>(workflow->second).GetWithDefault<int>(0) != 0;
    for (const Input& input : inputs) {
        const TfToken name(input.name);
        const auto linked = shader.inputConnections.find(name);
        if (linked != shader.inputConnections.end() && !linked->second.empty()) {
            const auto feed = builder.Feed(linked->second.front());
            if (feed) {
                const bool one = feed->channel == irt::Connection::rgb && !input.vector;
                material.connected[static_cast<std::size_t>(input.input)] = {
                    feed->node, one ? std::uint8_t{0} : feed->channel};
                continue;
            }
        }
        const auto value = shader.parameters.find(name);
        if (value != shader.parameters.end())
            SetConstant(value->second, input, id, input.field(material));
    }
    material.nodes = builder.Take();
    if (material.nodes.size() > irt::max_shade_nodes) {
        TF_WARN("<%s>: a network of %zu nodes; expected at most %zu; defaults are rendered",
                id.GetText(), material.nodes.size(), irt::max_shade_nodes);
        material.nodes.clear();
        material.connected = {};
    }
    return material;
}

PXR_NAMESPACE_CLOSE_SCOPE
