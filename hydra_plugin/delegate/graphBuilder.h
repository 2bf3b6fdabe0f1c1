// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "delegate/textures.h"
#include "irt/scene/material.h"
#include "pxr/imaging/hd/material.h"

PXR_NAMESPACE_OPEN_SCOPE

/// A constant of a node: a number fills all four components, a shorter vector is padded 0, 0, 1.
using HdIrtSlot = std::array<float, 4>;

/// How many components `value` has; 0: it is none of numbers, and `slot` stands.
int HdIrtConstant(const VtValue& value, HdIrtSlot& slot);

/// Makes the nodes of a network, of those alone that are asked for.
class HdIrtGraphBuilder {
  public:
    HdIrtGraphBuilder(const HdMaterialNetwork2& network, HdIrtTextures& textures)
        : _network(network), _textures(textures) {}

    /// The node behind a connection and which of its values it is; empty, and warned of, where it
    /// feeds nothing.
    std::optional<irt::Connection> Feed(const HdMaterialConnection2& connection);
    /// All nodes, each after those that it reads.
    std::vector<irt::ShadeNode> Take() { return std::move(_nodes); }

  private:
    struct Slot {
        std::int32_t node = irt::ShadeNode::unconnected;
        HdIrtSlot constant{};
    };
    std::int32_t _Add(irt::ShadeNode node);
    std::int32_t _Constant(const HdIrtSlot& value);
    Slot _Slot(const HdMaterialNode2& shader, const char* name, const HdIrtSlot& otherwise);
    std::int32_t _Texture(const HdMaterialNode2& shader, const SdfPath& path);
    std::int32_t _Transform(const HdMaterialNode2& shader);
    std::int32_t _Primvar(const HdMaterialNode2& shader);

    const HdMaterialNetwork2& _network;
    HdIrtTextures& _textures;
    std::vector<irt::ShadeNode> _nodes;
    std::map<SdfPath, std::int32_t> _made;
    std::set<SdfPath> _open;  ///< whose inputs are being followed, from the surface upstream
};

PXR_NAMESPACE_CLOSE_SCOPE
