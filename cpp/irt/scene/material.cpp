// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/material.h"

#include <algorithm>
#include <stdexcept>

namespace irt {

bool is_uniform(const Material& material) {
    const auto connected = [](const Connection& c) { return static_cast<bool>(c); };
    return material.normal == V3f(0, 0, 1) &&
           std::none_of(material.connected.begin(), material.connected.end(), connected);
}

void check(const Material& material, const std::string& name) {
    const auto refuse = [&](const std::string& what) {
        throw std::invalid_argument(name + ": " + what);
    };
    const auto count = static_cast<std::int32_t>(material.nodes.size());
    if (material.nodes.size() > max_shade_nodes)
        refuse("its graph has " + std::to_string(count) + " nodes, more than " +
               std::to_string(max_shade_nodes));
    for (std::int32_t n = 0; n < count; ++n) {
        const ShadeNode& node = material.nodes[static_cast<std::size_t>(n)];
        const std::string which = "node " + std::to_string(n);
        for (const std::int32_t input : node.inputs)
            if (input < ShadeNode::unconnected || input >= n)
                refuse(which + " reads node " + std::to_string(input) +
                       ", which is no earlier one");
        if (node.op == Op::Texture && !node.texture) refuse(which + " has no texture");
    }
    for (const Connection& connection : material.connected)
        if (connection.node < ShadeNode::unconnected || connection.node >= count)
            refuse("an input is connected to node " + std::to_string(connection.node) + " of " +
                   std::to_string(count));
}

std::vector<std::int32_t> nodes_behind(const Material& material,
                                       const std::vector<SurfaceInput>& inputs) {
    std::vector<bool> behind(material.nodes.size());
    for (const SurfaceInput input : inputs)
        if (const Connection& c = material.connection(input))
            behind[static_cast<std::size_t>(c.node)] = true;
    std::vector<std::int32_t> found;
    for (std::size_t n = behind.size(); n-- > 0;) {
        if (!behind[n]) continue;
        found.push_back(static_cast<std::int32_t>(n));
        for (const std::int32_t input : material.nodes[n].inputs)
            if (input != ShadeNode::unconnected) behind[static_cast<std::size_t>(input)] = true;
    }
    std::reverse(found.begin(), found.end());
    return found;
}

bool reads_place(const Material& material, const std::vector<std::int32_t>& nodes) {
    return std::any_of(nodes.begin(), nodes.end(), [&](std::int32_t n) {
        const Op op = material.nodes[static_cast<std::size_t>(n)].op;
        return op >= Op::Position && op <= Op::NormalToObject;
    });
}

SurfaceValues::SurfaceValues(const Material& m)
    : diffuse_color(m.diffuse_color),
      emissive_color(m.emissive_color),
      specular_color(m.specular_color),
      use_specular_workflow(m.use_specular_workflow),
      opacity_is_presence(m.opacity_is_presence),
      metallic(static_cast<double>(m.metallic)),
      roughness(static_cast<double>(m.roughness)),
      clearcoat(static_cast<double>(m.clearcoat)),
      clearcoat_roughness(static_cast<double>(m.clearcoat_roughness)),
      opacity(static_cast<double>(m.opacity)),
      opacity_threshold(static_cast<double>(m.opacity_threshold)),
      ior(static_cast<double>(m.ior)),
      normal(m.normal),
      transmission_color(m.transmission_color) {}

bool tint_varies(const Material& material) {
    return material.connection(SurfaceInput::Opacity) ||
           material.connection(SurfaceInput::OpacityThreshold) ||
           (material.connection(SurfaceInput::DiffuseColor) && effective_opacity(material) < 1 &&
            !is_presence(material));
}

double effective_opacity(const SurfaceValues& values) {
    if (values.opacity_threshold > 0) return values.opacity >= values.opacity_threshold ? 1 : 0;
    return std::clamp(values.opacity, 0.0, 1.0);
}

}  // namespace irt
