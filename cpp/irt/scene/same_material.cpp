// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>
#include <utility>

#include "irt/math/bits.h"
#include "irt/mutant.h"
#include "irt/scene/compile.h"
#include "irt/scene/equality.h"

namespace irt {

namespace {

bool same(const std::shared_ptr<const Texture>& a, const std::shared_ptr<const Texture>& b) {
    return a == b || (a && b && irt::same(*a, *b));
}

/// Whether two nodes do the same with what they read.
bool same_operation(const ShadeNode& a, const ShadeNode& b) {
    return a.op == b.op && same_bits(a.constants, b.constants) && a.primvar == b.primvar &&
           same(a.texture, b.texture) && a.wrap_s == b.wrap_s && a.wrap_t == b.wrap_t &&
           a.swizzle == b.swizzle;
}

bool same(const Connection& a, const Connection& b) {
    return a.node == b.node && a.channel == b.channel;
}

/// Whether two nodes of two graphs compute the same, numbered alike or not.
class SameGraph {
  public:
    SameGraph(const Material& a, const Material& b) : a_(a), b_(b) {}

    bool operator()(std::int32_t a, std::int32_t b) {
        if (a == ShadeNode::unconnected || b == ShadeNode::unconnected) return a == b;
        if (!seen_.emplace(a, b).second) return true;  // told already
        const ShadeNode &x = a_.nodes[static_cast<std::size_t>(a)],
                        &y = b_.nodes[static_cast<std::size_t>(b)];
        if (!same_operation(x, y)) return false;
        for (std::size_t i = 0; i < x.inputs.size(); ++i)
            if (!(*this)(x.inputs[i], y.inputs[i])) return false;
        return true;
    }

  private:
    const Material &a_, &b_;
    std::set<std::pair<std::int32_t, std::int32_t>> seen_;
};

}  // namespace

bool same(const Material& a, const Material& b) {
    return same_bits(a.diffuse_color, b.diffuse_color) &&
           same_bits(a.emissive_color, b.emissive_color) &&
           same_bits(a.specular_color, b.specular_color) &&
           a.use_specular_workflow == b.use_specular_workflow &&
           a.opacity_is_presence == b.opacity_is_presence && same_bits(a.metallic, b.metallic) &&
           same_bits(a.roughness, b.roughness) && same_bits(a.clearcoat, b.clearcoat) &&
           same_bits(a.clearcoat_roughness, b.clearcoat_roughness) &&
           same_bits(a.opacity, b.opacity) && same_bits(a.opacity_threshold, b.opacity_threshold) &&
           same_bits(a.ior, b.ior) && same_bits(a.normal, b.normal) &&
           same_bits(a.transmission_color, b.transmission_color) &&
           std::equal(a.connected.begin(), a.connected.end(), b.connected.begin(),
                      [](const Connection& x, const Connection& y) { return same(x, y); }) &&
           std::equal(a.nodes.begin(), a.nodes.end(), b.nodes.begin(), b.nodes.end(),
                      [](const ShadeNode& x, const ShadeNode& y) {
                          return x.inputs == y.inputs && same_operation(x, y);
                      });
}

bool same_tint(const Material& a, const Material& b) {
    if (!tint_varies(a) && !tint_varies(b)) return shadow_depth(a) == shadow_depth(b);
    if (mutated(Mutant::tint_graph_ignored)) return true;
    SameGraph same_graph(a, b);
    return same_bits(a.diffuse_color, b.diffuse_color) && same_bits(a.opacity, b.opacity) &&
           same_bits(a.opacity_threshold, b.opacity_threshold) &&
           a.opacity_is_presence == b.opacity_is_presence &&
           std::all_of(tint_inputs.begin(), tint_inputs.end(), [&](SurfaceInput input) {
               const Connection &x = a.connection(input), &y = b.connection(input);
               return x.channel == y.channel && same_graph(x.node, y.node);
           });
}

}  // namespace irt
