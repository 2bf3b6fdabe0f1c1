// SPDX-License-Identifier: Apache-2.0
#include "delegate/graphBuilder.h"

#include <algorithm>

#include "pxr/base/gf/vec2f.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/diagnostic.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/usd/sdf/assetPath.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr std::int32_t none = irt::ShadeNode::unconnected;
const HdIrtSlot ones{1, 1, 1, 1}, zeros{0, 0, 0, 0};

const VtValue* Parameter(const HdMaterialNode2& shader, const char* name) {
    const auto found = shader.parameters.find(TfToken(name));
    return found == shader.parameters.end() ? nullptr : &found->second;
}

std::string Text(const HdMaterialNode2& shader, const char* name, const std::string& otherwise) {
    const VtValue* value = Parameter(shader, name);
    if (!value) return otherwise;
    if (value->IsHolding<TfToken>()) return value->UncheckedGet<TfToken>().GetString();
    if (value->IsHolding<std::string>()) return value->UncheckedGet<std::string>();
    return otherwise;
}

/// What scale and bias turn into `fallback`: they are of the texture alone.
HdIrtSlot Before(const HdIrtSlot& fallback, const HdIrtSlot& scale, const HdIrtSlot& bias) {
    HdIrtSlot out;
    for (std::size_t c = 0; c < 4; ++c)
        out[c] = scale[c] != 0 ? static_cast<float>((static_cast<double>(fallback[c]) - bias[c]) /
                                                    static_cast<double>(scale[c]))
                               : fallback[c];
    return out;
}

/// Components of the padding of shorter vectors.
HdIrtSlot Padding(const std::string& kind) {
    if (kind == "float2") return {0, 0, 0, 1};
    if (kind == "float3" || kind == "normal" || kind == "point" || kind == "vector")
        return {0, 0, 0, 1};
    return zeros;
}

constexpr char texture[] = "UsdUVTexture", transform[] = "UsdTransform2d",
               reader[] = "UsdPrimvarReader_";

bool Known(const std::string& kind) {
    if (kind == texture || kind == transform) return true;
    static const std::set<std::string> readers{"float",  "int",    "float2", "float3",
                                               "float4", "normal", "point",  "vector"};
    return TfStringStartsWith(kind, reader) && readers.count(kind.substr(sizeof(reader) - 1)) != 0;
}

std::uint8_t Channel(const std::string& kind, const std::string& output) {
    if (kind == texture) {
        const std::size_t place = std::string("rgba").find(output);
        return output.size() == 1 && place < 4 ? static_cast<std::uint8_t>(place)
                                               : irt::Connection::rgb;
    }
    const bool number =
        kind == std::string(reader) + "float" || kind == std::string(reader) + "int";
    return number ? std::uint8_t{0} : irt::Connection::rgb;
}

}  // namespace

int HdIrtConstant(const VtValue& value, HdIrtSlot& slot) {
    const auto fill = [&](const auto& v, std::size_t size) {
        slot = {0, 0, 0, 1};
        for (std::size_t c = 0; c < size; ++c) slot[c] = static_cast<float>(v[c]);
        return static_cast<int>(size);
    };
    const VtValue v4 = VtValue::Cast<GfVec4f>(value), v3 = VtValue::Cast<GfVec3f>(value),
                  v2 = VtValue::Cast<GfVec2f>(value);
    if (!v4.IsEmpty()) return fill(v4.UncheckedGet<GfVec4f>(), 4);
    if (!v3.IsEmpty()) return fill(v3.UncheckedGet<GfVec3f>(), 3);
    if (!v2.IsEmpty()) return fill(v2.UncheckedGet<GfVec2f>(), 2);
    const VtValue number = VtValue::Cast<float>(value);
    if (number.IsEmpty()) return 0;
    slot.fill(number.UncheckedGet<float>());
    return 1;
}

std::int32_t HdIrtGraphBuilder::_Add(irt::ShadeNode node) {
    _nodes.push_back(std::move(node));
    return static_cast<std::int32_t>(_nodes.size()) - 1;
}

std::int32_t HdIrtGraphBuilder::_Constant(const HdIrtSlot& value) {
    irt::ShadeNode node;
    node.constants[0] = value;
    return _Add(std::move(node));
}

std::optional<irt::Connection> HdIrtGraphBuilder::Feed(const HdMaterialConnection2& connection) {
    const SdfPath& path = connection.upstreamNode;
    const auto found = _network.nodes.find(path);
    if (found == _network.nodes.end()) return std::nullopt;
    const HdMaterialNode2& shader = found->second;
    const std::string kind = shader.nodeTypeId.GetString();
    if (_open.count(path) != 0) {
        TF_WARN("<%s>: a connection that leads back to itself", path.GetText());
        return std::nullopt;
    }
    if (_made.count(path) == 0) {
        _open.insert(path);
        std::int32_t made = none;
        if (!Known(kind)) {
            TF_WARN(
                "<%s>: the shader node %s is not rendered; its fallback, or the input's "
                "default, is",
                path.GetText(), kind.c_str());
            HdIrtSlot fallback;
            const VtValue* value = Parameter(shader, "fallback");
            if (value && HdIrtConstant(*value, fallback) != 0) made = _Constant(fallback);
        } else if (kind == texture) {
            made = _Texture(shader, path);
        } else {
            made = kind == transform ? _Transform(shader) : _Primvar(shader);
        }
        _open.erase(path);
        _made[path] = made;
    }
    const std::int32_t node = _made[path];
    if (node == none) return std::nullopt;
    return irt::Connection{node, Channel(kind, connection.upstreamOutputName.GetString())};
}

HdIrtGraphBuilder::Slot HdIrtGraphBuilder::_Slot(const HdMaterialNode2& shader, const char* name,
                                                 const HdIrtSlot& otherwise) {
    const auto linked = shader.inputConnections.find(TfToken(name));
    if (linked != shader.inputConnections.end() && !linked->second.empty()) {
        if (const auto feed = Feed(linked->second.front())) {
            if (feed->channel == irt::Connection::rgb) return {feed->node, zeros};
            irt::ShadeNode spread;
            spread.op = irt::Op::Swizzle;
            spread.inputs[0] = feed->node;
            spread.swizzle.fill(feed->channel);
            return {_Add(std::move(spread)), zeros};
        }
    }
    Slot slot{none, otherwise};
    if (const VtValue* value = Parameter(shader, name)) HdIrtConstant(*value, slot.constant);
    return slot;
}

std::int32_t HdIrtGraphBuilder::_Texture(const HdMaterialNode2& shader, const SdfPath& path) {
    const Slot scale = _Slot(shader, "scale", ones), bias = _Slot(shader, "bias", zeros);
    Slot fallback = _Slot(shader, "fallback", {0, 0, 0, 1});
    SdfAssetPath file;
    if (const VtValue* value = Parameter(shader, "file"))
        file = value->GetWithDefault<SdfAssetPath>(file);
    const auto instead = [&](const Slot& slot) {
        return slot.node != none ? slot.node : _Constant(slot.constant);
    };
    if (file.GetAssetPath().empty()) return instead(fallback);
    const Slot st = _Slot(shader, "st", {0, 0, 0, 1});
    if (scale.node == none && bias.node == none && fallback.node == none)
        fallback.constant = Before(fallback.constant, scale.constant, bias.constant);
    std::string space = Text(shader, "sourceColorSpace", "auto");
    if (space == "auto") space = Text(shader, "colorSpace:file", "auto");
    const HdIrtTexture found = _textures.Find(file, space, Text(shader, "wrapS", "useMetadata"),
                                              Text(shader, "wrapT", "useMetadata"), path);
    std::int32_t index;
    if (found.texture) {
        irt::ShadeNode node;
        node.op = irt::Op::Texture;
        node.inputs[0] = st.node;
        node.inputs[1] = fallback.node;
        node.constants[0] = st.constant;
        node.constants[1] = fallback.constant;
        node.texture = found.texture;
        node.wrap_s = found.wrap_s;
        node.wrap_t = found.wrap_t;
        index = _Add(std::move(node));
    } else {
        irt::ShadeNode node;
        node.inputs[0] = fallback.node;
        node.constants[0] = fallback.constant;
        index = _Add(std::move(node));
    }
    const auto apply = [&](irt::Op op, const Slot& slot, const HdIrtSlot& neutral) {
        if (slot.node == none && slot.constant == neutral) return;
        irt::ShadeNode node;
        node.op = op;
        node.inputs[0] = index;
        node.inputs[1] = slot.node;
        node.constants[1] = slot.constant;
        index = _Add(std::move(node));
    };
    apply(irt::Op::Multiply, scale, ones);
    apply(irt::Op::Add, bias, zeros);
    return index;
}

std::int32_t HdIrtGraphBuilder::_Transform(const HdMaterialNode2& shader) {
    const Slot slots[] = {_Slot(shader, "in", {0, 0, 0, 1}), _Slot(shader, "scale", {1, 1, 0, 1}),
                          _Slot(shader, "rotation", zeros),
                          _Slot(shader, "translation", {0, 0, 0, 1})};
    irt::ShadeNode node;
    node.op = irt::Op::Transform2d;
    for (std::size_t i = 0; i < 4; ++i) {
        node.inputs[i] = slots[i].node;
        node.constants[i] = slots[i].constant;
    }
    return _Add(std::move(node));
}

std::int32_t HdIrtGraphBuilder::_Primvar(const HdMaterialNode2& shader) {
    const std::string kind = shader.nodeTypeId.GetString().substr(sizeof(reader) - 1);
    std::string name = Text(shader, "varname", "");
    if (TfStringStartsWith(name, "primvars:")) name = name.substr(9);
    const Slot fallback = _Slot(shader, "fallback", Padding(kind));
    if (name.empty()) return fallback.node != none ? fallback.node : _Constant(fallback.constant);
    irt::ShadeNode node;
    node.op = irt::Op::Primvar;
    node.inputs[0] = fallback.node;
    node.constants[0] = fallback.constant;
    node.primvar = name;
    return _Add(std::move(node));
}

PXR_NAMESPACE_CLOSE_SCOPE
