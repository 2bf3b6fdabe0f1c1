// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/shading.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "irt/math/libm.h"
#include "irt/trace/ray_origin.h"

namespace irt::shade {

namespace {

/// Steps an octave of throughput in which branches are priced.
constexpr double price_scale = 16;

/// From the point to the light, of any length.
V3d towards(const VisiblePoint& point, const LightSlot& light) {
    return light.record.kind == LightKind::Distant ? -light.record.direction
                                                   : light.position_render - point.surface.position;
}

/// The shadow ray to a light in direction `unit`.
trace::Ray ray_towards(const VisiblePoint& point, const LightSlot& light, const V3d& unit) {
    const V3f narrowed(unit);
    const V3f origin = offset_ray_origin(point.surface, V3d(narrowed));
    if (light.record.kind == LightKind::Distant) return trace::make_ray(origin, narrowed);
    return trace::make_ray(origin, V3f(light.position_render - V3d(origin)), 1.0f);
}

/// Thirty-seconds of an octave's linear stretch, each with what floor(16 log2(m)) is at its lower
/// end and the one mantissa, if any, from which on it is one more. The mantissas are the least
/// floats that are at least 2^(k/16): between floats and the true powers there is so much room that
/// the rounding of no logarithm matters (tests/cpp/test_price.cpp compares every mantissa).
struct OctaveStretch {
    int steps;
    std::uint32_t mantissa;  ///< 23 bits
};

constexpr int stretches = 32, mantissa_bits = 23;

constexpr std::array<OctaveStretch, stretches> octave() {
    constexpr std::uint32_t steps[] = {0x05aac4, 0x0b95c2, 0x11c3d4, 0x1837f1, 0x1ef533,
                                       0x25fed7, 0x2d583f, 0x3504f4, 0x3d08a4, 0x45672b,
                                       0x4e248d, 0x5744fd, 0x60ccdf, 0x6ac0c7, 0x75257e};
    std::array<OctaveStretch, stretches> out{};
    for (std::uint32_t i = 0; i < stretches; ++i) {
        const std::uint32_t first = i << (mantissa_bits - 5);
        int passed = 0;
        while (passed < 15 && steps[passed] <= first) ++passed;
        out[i] = {passed, passed < 15 ? steps[passed] : 1u << mantissa_bits};
    }
    return out;
}

}  // namespace

Shading::Shading(const Scene& scene, const Settings& settings)
    : scene_(scene),
      max_depth_(settings.max_depth),
      cost_limit_(static_cast<std::int64_t>(
          std::floor(-price_scale * libm::log2(settings.throughput_cutoff)))) {
    responses_.reserve(scene.materials().size());
    for (const MaterialSlot& material : scene.materials())
        responses_.push_back(make_response(material.record, settings.mirror_roughness));
}

VisiblePoint Shading::visible_point(const trace::Ray& ray, const trace::Hit& hit) const {
    const Surface& surface = scene_.objects()[hit.object].part(hit.part);
    VisiblePoint point{surface_point(scene_, ray, hit),
                       responses_[surface.material],
                       normalized(V3d(ray.direction)),
                       {},
                       {}};
    const double side = point.surface.front ? 1 : -1;
    point.shading = point.surface.shading_normal * side;
    point.geometric = point.surface.geometric_normal * side;
    return point;
}

FirstHit Shading::first_hit(const VisiblePoint& point, const trace::Hit& hit) const {
    return {true, point.surface.position, V3f(point.shading),
            scene_.materials()[point.surface.material].record.diffuse_color,
            scene_.objects()[hit.object].id};
}

std::optional<LightSample> Shading::light_sample(const VisiblePoint& point,
                                                 const LightSlot& light) const {
    if (point.response.invisible) return std::nullopt;
    const V3d to_light = towards(point, light);
    const double squared = to_light.dot(to_light);
    if (!(squared > 0)) return std::nullopt;
    const V3d unit = divided(to_light, std::sqrt(squared));
    if (!(point.geometric.dot(unit) > 0)) return std::nullopt;
    V3d response = reflected_share(point.response, point.shading, unit, -point.direction);
    if (light.record.kind == LightKind::Point) response = divided(response, squared);
    if (V3f(response) == V3f(0, 0, 0)) return std::nullopt;
    LightSample sample{response, std::nullopt};
    if (!light.record.casts_shadows) return sample;
    sample.shadow_ray = ray_towards(point, light, unit);
    return sample;
}

trace::Ray Shading::shadow_ray(const VisiblePoint& point, const LightSlot& light) const {
    const V3d to_light = towards(point, light);
    return ray_towards(point, light, normalized(to_light));
}

Spawned Shading::spawned(const VisiblePoint& point) const {
    return spawn(point.response, point.direction, point.shading, point.geometric,
                 point.surface.front);
}

trace::Ray Shading::spawned_ray(const VisiblePoint& point, const V3d& direction) const {
    // Narrowed first: near grazing, narrowing may turn a direction to the surface's other side.
    const V3f narrowed(direction);
    return trace::make_ray(offset_ray_origin(point.surface, V3d(narrowed)), narrowed);
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

std::optional<std::int64_t> price(const V3f& weight) {
    const double largest = static_cast<double>(std::max({weight.x, weight.y, weight.z}));
    if (!(largest > 0)) return std::nullopt;
    // ceil(-16 log2(m 2^e)) = -16 e - floor(16 log2(m)).
    static constexpr std::array<OctaveStretch, stretches> table = octave();
    const auto bits = std::bit_cast<std::uint64_t>(largest);  // a double: never subnormal
    const auto exponent = static_cast<std::int64_t>(bits >> 52) - 1023;
    const auto mantissa =
        static_cast<std::uint32_t>(bits >> (52 - mantissa_bits)) & ((1u << mantissa_bits) - 1);
    const OctaveStretch& stretch = table[mantissa >> (mantissa_bits - 5)];
    return -16 * exponent - stretch.steps - (mantissa >= stretch.mantissa ? 1 : 0);
}

}  // namespace irt::shade
