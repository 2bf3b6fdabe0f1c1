// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "irt/math/libm.h"
#include "irt/scene/emission.h"
#include "irt/shade/footprint.h"
#include "irt/shade/normal_map.h"
#include "irt/trace/ray_origin.h"

namespace irt::shade {

namespace {

/// The shadow ray to a light in direction `unit`.
trace::Ray ray_towards(const VisiblePoint& point, const LightSlot& light, const V3d& unit) {
    const V3f narrowed(unit);
    const V3f origin = offset_ray_origin(point.surface, V3d(narrowed));
    const float limit = light.record.shadow_distance;
    if (light.record.kind == LightKind::Distant)
        return limit < 0 ? trace::make_ray(origin, narrowed)
                         : trace::make_ray(origin, narrowed, limit);
    const V3d way = light.position_render - V3d(origin);
    float t_max = 1;
    if (limit >= 0)
        t_max =
            static_cast<float>(std::min(1.0, static_cast<double>(limit) / std::sqrt(way.dot(way))));
    return trace::make_ray(origin, V3f(way), t_max);
}

std::vector<std::int32_t> all_nodes(const Material& material) {
    std::vector<std::int32_t> nodes(material.nodes.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
}

}  // namespace

Shading::Shading(const Scene& scene, const Settings& settings, const RayCone& cone)
    : scene_(scene),
      max_depth_(settings.max_depth),
      mirror_roughness_(settings.mirror_roughness),
      cone_(cone),
      cost_limit_(static_cast<std::int64_t>(
          std::floor(-price_scale * libm::log2(settings.throughput_cutoff)))),
      held_out_(black_response()) {
    responses_.reserve(scene.materials().size());
    for (const MaterialSlot& material : scene.materials()) {
        responses_.push_back(make_response(material.record, settings.mirror_roughness));
        varies_.push_back(!is_uniform(material.record));
        any_varies_ = any_varies_ || varies_.back();
        placed_.push_back(varies_.back() &&
                          reads_place(material.record, all_nodes(material.record)));
        emits_ = emits_ || responses_.back().emission != V3d(0, 0, 0) ||
                 material.record.connection(SurfaceInput::EmissiveColor);
    }
}

VisiblePoint Shading::visible_point(const trace::Ray& ray, const trace::Hit& hit,
                                    double travelled) const {
    const trace::SurfacePoint surface = surface_point(scene_, ray, hit);
    VisiblePoint point{
        surface, &responses_[surface.material],  std::nullopt, normalized(V3d(ray.direction)), {},
        {},      scene_.object_index(hit.object)};
    if (varies_[surface.material]) shade_locally(ray, hit, travelled, point);
    point.camera = ray.camera;
    if (ray.camera && !point.response().invisible() && scene_.matte(hit.object, hit.part)) {
        point.matte = true;
        point.local.reset();
        point.uniform = &held_out_;
    }
    const double side = point.surface.front ? 1 : -1;
    point.shading = point.surface.shading_normal * side;
    point.geometric = point.surface.geometric_normal * side;
    return point;
}

/// Evaluates the material's graph at `point`; its shading normal is the outward one still.
void Shading::shade_locally(const trace::Ray& ray, const trace::Hit& hit, double travelled,
                            VisiblePoint& point) const {
    graph::Site site{scene_, scene_.surface(hit.object, hit.part), hit};
    const M44d render_from_trace = scene_.render_from_trace(hit.object, hit.part);
    const double width = cone_.width + cone_.spread * (travelled + length(ray, hit.t));
    set_footprint(point.direction, point.surface.geometric_normal, width, render_from_trace, site);
    const Material& material = scene_.materials()[point.surface.material].record;
    std::optional<graph::Place> place;
    if (placed_[point.surface.material]) {
        const trace::SurfacePoint& at = point.surface;
        const auto [along, across] = footprint_axes(point.direction, at.geometric_normal, width);
        place.emplace(scene_, hit, at.position, at.shading_normal, point.direction, along, across);
        site.place = &*place;
    }
    const SurfaceValues values = graph::evaluate(material, site);
    point.local = make_response(values, mirror_roughness_);
    if (values.normal != V3d(0, 0, 1))
        point.surface.shading_normal =
            mapped_normal(material, site, render_from_trace, point.surface, values.normal);
}

FirstHit Shading::first_hit(const VisiblePoint& point, const trace::Hit& hit) {
    return {hit,
            point.surface.material,
            point.matte,
            point.surface.position,
            V3f(point.shading),
            V3d(V3f(point.response().base_color))};
}

std::optional<LightSample> Shading::light_sample(const VisiblePoint& point,
                                                 const LightSlot& light) const {
    const Light& record = light.record;
    if (record.kind == LightKind::Environment || point.response().invisible() ||
        !light.lights(point.object))
        return std::nullopt;
    const V3d to_light = towards(point.surface.position, light);
    const double squared = to_light.dot(to_light);
    if (!(squared > 0)) return std::nullopt;
    const V3d unit = divided(to_light, std::sqrt(squared));
    if (!(point.geometric.dot(unit) > 0)) return std::nullopt;
    V3d response =
        reflected_share(point.response(), point.shading, unit, -point.direction,
                        static_cast<double>(record.diffuse), static_cast<double>(record.specular));
    if (record.kind == LightKind::Point) response = divided(response, squared);
    if (light.shaped) response *= emission(record, -unit, squared);
    if (V3f(response) == V3f(0, 0, 0)) return std::nullopt;
    if (!record.casts_shadows) return LightSample{response, std::nullopt};
    return std::optional<LightSample>(std::in_place, response, ray_towards(point, light, unit));
}

trace::Ray Shading::shadow_ray(const VisiblePoint& point, const LightSlot& light) const {
    const V3d to_light = towards(point.surface.position, light);
    return ray_towards(point, light, normalized(to_light));
}

Spawned Shading::spawned(const VisiblePoint& point) const {
    return spawn(point.response(), point.direction, point.shading, point.geometric,
                 point.surface.front);
}

trace::Ray Shading::spawned_ray(const VisiblePoint& point, const V3d& direction) const {
    // Narrowed first: near grazing, narrowing may turn a direction to the surface's other side.
    const V3f narrowed(direction);
    trace::Ray ray = trace::make_ray(offset_ray_origin(point.surface, V3d(narrowed)), narrowed);
    // What goes by what is not there goes on as the ray it was.
    ray.camera = point.camera && point.response().presence < 1 && direction == point.direction;
    return ray;
}

V3d transmittance(const trace::Occlusion& occlusion) {
    V3d passed{1, 1, 1};
    for (int c = 0; c < 3; ++c) {
        const std::uint32_t depth = occlusion.depth.rgb[c];
        if (depth >= trace::depth_opaque)
            passed[c] = 0;
        else if (depth > 0)
            passed[c] = libm::exp2(-static_cast<double>(depth) / trace::depth_scale);
    }
    return passed;
}

V3d shadowed(const Light& light, const trace::Occlusion& occlusion) {
    const V3d passed = transmittance(occlusion);
    if (light.shadow_color == V3f(0, 0, 0)) return passed;
    return passed + (V3d(1, 1, 1) - passed) * V3d(light.shadow_color);
}

}  // namespace irt::shade
