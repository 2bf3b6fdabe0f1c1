// SPDX-License-Identifier: Apache-2.0
#include "irt/graph/evaluate.h"

#include <limits>

#include "irt/graph/operations.h"
#include "irt/scene/compile.h"
#include "irt/scene/primvar.h"
#include "irt/texture/filter.h"

namespace irt::graph {

namespace {

/// `v` within [low, high]; low where it is no number.
double bounded(double v, double low, double high) {
    if (!(v >= low)) return low;
    return v > high ? high : v;
}

constexpr double unbounded = std::numeric_limits<double>::max();
constexpr double least_ior = 1e-3;

class Evaluator {
  public:
    // The values stay unset until their nodes are run: there is room for many.
    Evaluator(const Material& material, const Site& site) : material_(material), site_(site) {}

    void run(std::int32_t index) {
        const ShadeNode& node = material_.nodes[static_cast<std::size_t>(index)];
        std::array<Value, 4> slots;
        for (std::size_t s = 0; s < slots.size(); ++s) slots[s] = slot(node, s);
        values_[static_cast<std::size_t>(index)] = value(node, slots);
    }

    /// The component(s) that feed an input; or what stands there, unconnected.
    void give(SurfaceInput input, V3d& to, double low) const {
        const Connection& c = material_.connection(input);
        if (!c) return;
        const Value& from = values_[static_cast<std::size_t>(c.node)];
        for (int i = 0; i < 3; ++i) {
            const auto component =
                c.channel == Connection::rgb ? static_cast<std::size_t>(i) : c.channel;
            to[i] = bounded(from[component].v, low, unbounded);
        }
    }
    void give(SurfaceInput input, double& to, double low, double high) const {
        const Connection& c = material_.connection(input);
        if (!c) return;
        const std::size_t component = c.channel == Connection::rgb ? 0 : c.channel;
        to = bounded(values_[static_cast<std::size_t>(c.node)][component].v, low, high);
    }
    void give_tint(SurfaceValues& out) const {
        give(SurfaceInput::DiffuseColor, out.diffuse_color, 0);
        give(SurfaceInput::Opacity, out.opacity, 0, 1);
        give(SurfaceInput::OpacityThreshold, out.opacity_threshold, 0, 1);
    }

  private:
    [[nodiscard]] Value slot(const ShadeNode& node, std::size_t s) const {
        if (node.inputs[s] != ShadeNode::unconnected)
            return values_[static_cast<std::size_t>(node.inputs[s])];
        Value constant{};
        for (std::size_t c = 0; c < 4; ++c)
            constant[c] = {static_cast<double>(node.constants[s][c]), 0, 0};
        return constant;
    }

    [[nodiscard]] Value value(const ShadeNode& node, const std::array<Value, 4>& slots) const {
        if (node.op == Op::Primvar) return primvar_value(site_, node.primvar).value_or(slots[0]);
        if (site_.place && node.op >= Op::Position && node.op <= Op::NormalToObject)
            return placed(node.op, slots[0]);
        if (node.op != Op::Texture) return operate(node, slots);
        const Value& st = slots[0];
        const std::optional<texture::Texel> texel =
            texture::look_up(*node.texture, node.wrap_s, node.wrap_t, {st[0].v, st[1].v},
                             {st[0].x, st[1].x}, {st[0].y, st[1].y});
        if (!texel) return slots[1];
        // How a texture changes across the footprint is not followed.
        return {
            Dual{(*texel)[0], 0, 0}, {(*texel)[1], 0, 0}, {(*texel)[2], 0, 0}, {(*texel)[3], 0, 0}};
    }

    /// A node that asks where the point lies.
    [[nodiscard]] Value placed(Op op, const Value& in) const {
        const Place& place = *site_.place;
        const auto each = [&](auto&& transform) {
            const auto vector = [&](double Dual::*part) {
                return transform(V3d(in[0].*part, in[1].*part, in[2].*part), part == &Dual::v);
            };
            return joined(vector(&Dual::v), vector(&Dual::x), vector(&Dual::y), in[3]);
        };
        switch (op) {
            case Op::Position:
                return joined(place.position, place.along, place.across, Dual{1, 0, 0});
            case Op::Normal:
                return joined(place.normal, V3d(0), V3d(0), Dual{0, 0, 0});
            case Op::View:
                return joined(place.view, V3d(0), V3d(0), Dual{0, 0, 0});
            case Op::PointToWorld:
            case Op::PointToObject: {
                const M44d& m =
                    op == Op::PointToWorld ? place.world_from_object : place.object_from_world;
                return each([&](const V3d& v, bool point) {
                    return point ? transform_point(m, v) : transform_direction(m, v);
                });
            }
            case Op::VectorToWorld:
            case Op::VectorToObject: {
                const M44d& m =
                    op == Op::VectorToWorld ? place.world_from_object : place.object_from_world;
                return each([&](const V3d& v, bool) { return transform_direction(m, v); });
            }
            default: {
                const M44d& m =
                    op == Op::NormalToWorld ? place.object_from_world : place.world_from_object;
                return each([&](const V3d& v, bool) { return transform_normal(m, v); });
            }
        }
    }
    static Value joined(const V3d& v, const V3d& x, const V3d& y, const Dual& fourth) {
        return {Dual{v.x, x.x, y.x}, {v.y, x.y, y.y}, {v.z, x.z, y.z}, fourth};
    }

    const Material& material_;
    const Site& site_;
    std::array<Value, max_shade_nodes> values_;  ///< of the nodes that were run
};

}  // namespace

Place::Place(const Scene& scene, const trace::Hit& hit, const V3d& position_render,
             const V3d& normal_render, const V3d& view_render, const V3d& along_render,
             const V3d& across_render) {
    const Surface& surface = scene.surface(hit.object, hit.part);
    world_from_object = surface.trace_from_shape * scene.render_from_trace(hit.object, hit.part);
    const M44d object_from_render = inverse_of(world_from_object);
    position = transform_point(object_from_render, position_render);
    normal = normalized(transform_normal(world_from_object, normal_render));
    view = normalized(transform_direction(object_from_render, view_render));
    along = transform_direction(object_from_render, along_render);
    across = transform_direction(object_from_render, across_render);
    const V3d& origin = scene.render_origin();
    for (int i = 0; i < 3; ++i) world_from_object[3][i] += origin[i];
    object_from_world = inverse_of(world_from_object);
}

std::optional<Value> primvar_value(const Site& site, std::string_view name) {
    Value out{};
    out[3].v = 1;
    if (const Triangles* const triangles = site.surface.triangles.get()) {
        if (const Primvar* const primvar = find_primvar(triangles->mesh->primvars, name)) {
            const auto [a, b, c] = corner_values(*triangles, *primvar, site.hit.primitive);
            for (std::size_t i = 0; i < static_cast<std::size_t>(primvar->width); ++i) {
                const double along_u = b[i] - a[i], along_v = c[i] - a[i];
                out[i] = {a[i] + along_u * site.hit.u + along_v * site.hit.v,
                          along_u * site.u_x + along_v * site.v_x,
                          along_u * site.u_y + along_v * site.v_y};
            }
            return out;
        }
    }
    // Across a ball's or a curve's width no primvar varies; along a curve it is not followed.
    const auto take = [&](int width, const PrimvarValue& value) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(width); ++i) out[i] = {value[i], 0, 0};
        return out;
    };
    const trace::Hit& hit = site.hit;
    if (const Spheres* const spheres = site.surface.spheres.get()) {
        if (const Primvar* const primvar = find_primvar(spheres->primvars, name))
            return take(primvar->width, primvar_at(*spheres, *primvar, hit.primitive));
    } else if (const Curves* const curves = site.surface.curves.get()) {
        if (const Primvar* const primvar = find_primvar(curves->primvars, name))
            return take(primvar->width, primvar_at(*curves, *primvar, hit.primitive, hit.u));
    }
    if (const Primvar* const primvar = find_primvar(site.surface.primvars, name))
        return take(primvar->width, constant_value(*primvar));
    if (const auto given = instance_primvar(site.scene, hit, name))
        return take(given->width, given->value);
    return std::nullopt;
}

SurfaceValues evaluate(const Material& material, const Site& site) {
    SurfaceValues out(material);
    Evaluator graph(material, site);
    for (std::int32_t n = 0; n < static_cast<std::int32_t>(material.nodes.size()); ++n)
        graph.run(n);
    graph.give_tint(out);
    graph.give(SurfaceInput::EmissiveColor, out.emissive_color, 0);
    graph.give(SurfaceInput::SpecularColor, out.specular_color, 0);
    graph.give(SurfaceInput::Metallic, out.metallic, 0, 1);
    graph.give(SurfaceInput::Roughness, out.roughness, 0, 1);
    graph.give(SurfaceInput::Clearcoat, out.clearcoat, 0, 1);
    graph.give(SurfaceInput::ClearcoatRoughness, out.clearcoat_roughness, 0, 1);
    graph.give(SurfaceInput::Ior, out.ior, least_ior, unbounded);
    graph.give(SurfaceInput::Normal, out.normal, -unbounded);
    graph.give(SurfaceInput::TransmissionColor, out.transmission_color, 0);
    return out;
}

trace::OpticalDepth tint_at(const MaterialSlot& material, const Site& site) {
    SurfaceValues values(material.record);
    Evaluator graph(material.record, site);
    for (const std::int32_t n : material.tint_nodes) graph.run(n);
    graph.give_tint(values);
    return shadow_depth(values);
}

}  // namespace irt::graph
