// SPDX-License-Identifier: Apache-2.0
// Everything between a hit and its share of a pixel that needs no tree: visible points, responses,
// spawned rays, prices of branches. Pure functions of scene, settings and hit, so that whatever is
// kept of a ray tree and whatever is recomputed agree to the bit.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "irt/scene/scene.h"
#include "irt/scene/sky.h"
#include "irt/shade/price.h"
#include "irt/shade/response.h"
#include "irt/shade/settings.h"
#include "irt/trace/intersector.h"

namespace irt::shade {

/// The first surface along a ray, ready to shade.
struct VisiblePoint {
    trace::SurfacePoint surface;
    const Response* uniform;        ///< the material's, where it is the same everywhere
    std::optional<Response> local;  ///< else
    V3d direction;                  ///< unit, of the ray that sees it
    V3d shading, geometric;         ///< unit normals on the side the ray came from
    std::uint32_t object = 0;       ///< index into Scene::all_objects()
    bool camera = false;            ///< the ray is a camera ray
    bool matte = false;             ///< held out of it: nothing comes from here

    [[nodiscard]] const Response& response() const { return local ? *local : *uniform; }
};

/// The cone of a sample's ray: where it has come `distance`, it is `width` + `spread` * distance
/// wide. Mirrors and refraction leave the spread as it is.
struct RayCone {
    double width = 0;   ///< render-space units
    double spread = 0;  ///< per unit of distance
};

/// The first visible surface of a sample, for AOVs and coverage: what it is, and, where a surface
/// is asked for, how it looks.
struct FirstHit {
    trace::Hit seen;              ///< where no surface is asked for, its names alone
    std::uint32_t material = 0;   ///< slot
    bool matte = false;           ///< held out: it covers nothing
    V3d position{0, 0, 0};        ///< render space
    V3f shading_normal{0, 0, 0};  ///< unit, render orientation, on the viewer's side
    V3d albedo{0, 0, 0};

    explicit operator bool() const { return static_cast<bool>(seen); }
};

/// What a light would add at a visible point were nothing in between, at unit energy, and the
/// shadow ray that tells what is, unless the light casts no shadows.
struct LightSample {
    V3d response;
    std::optional<trace::Ray> shadow_ray;
};

class Shading {
  public:
    Shading(const Scene& scene, const Settings& settings, const RayCone& cone);

    [[nodiscard]] const Scene& scene() const { return scene_; }
    /// Whether some material emits light.
    [[nodiscard]] bool emits() const { return emits_; }
    [[nodiscard]] int max_depth() const { return max_depth_; }

    /// Of a uniform material, by slot.
    [[nodiscard]] const Response& response(std::uint32_t material) const {
        return responses_[material];
    }
    /// Whether a material, by slot, is evaluated at every point; then visible_point needs to know
    /// how far the ray has come.
    [[nodiscard]] bool varies(std::uint32_t material) const { return varies_[material]; }
    /// Whether some material does.
    [[nodiscard]] bool any_varies() const { return any_varies_; }
    /// The length of `ray` from its origin to `t`.
    [[nodiscard]] static double length(const trace::Ray& ray, double t) {
        const V3d d(ray.direction);
        return t * std::sqrt(d.dot(d));
    }
    /// `travelled`: lengths of the rays that led to this one, summed in their order.
    [[nodiscard]] VisiblePoint visible_point(const trace::Ray& ray, const trace::Hit& hit,
                                             double travelled) const;
    /// What a ray that meets nothing sees of a light at unit energy.
    [[nodiscard]] V3f seen_beyond(const LightSlot& light, const trace::Ray& ray) const {
        const Light& record = light.record;
        if (record.kind != LightKind::Environment || (ray.camera && !record.camera_visible))
            return {0, 0, 0};
        if (!record.sky) return {1, 1, 1};
        return V3f(seen_in(*record.sky, V3d(ray.direction), cone_.spread));
    }
    [[nodiscard]] static FirstHit first_hit(const VisiblePoint& point, const trace::Hit& hit);
    /// Empty where the light adds nothing whatever is in between.
    [[nodiscard]] std::optional<LightSample> light_sample(const VisiblePoint& point,
                                                          const LightSlot& light) const;
    /// From a position (render space) to a light, of any length, but for point lights the whole
    /// way.
    [[nodiscard]] static V3d towards(const V3d& position, const LightSlot& light) {
        return light.record.kind == LightKind::Point ? light.position_render - position
                                                     : -light.record.direction;
    }
    /// The shadow ray from a point to a light.
    [[nodiscard]] trace::Ray shadow_ray(const VisiblePoint& point, const LightSlot& light) const;
    [[nodiscard]] Spawned spawned(const VisiblePoint& point) const;
    [[nodiscard]] trace::Ray spawned_ray(const VisiblePoint& point, const V3d& direction) const;

    /// True if a branch of this summed price is traced.
    [[nodiscard]] bool affordable(std::int64_t cost) const { return cost <= cost_limit_; }

  private:
    void shade_locally(const trace::Ray& ray, const trace::Hit& hit, double travelled,
                       VisiblePoint& point) const;

    const Scene& scene_;
    int max_depth_;
    double mirror_roughness_;
    RayCone cone_;
    bool emits_ = false, any_varies_ = false;
    std::int64_t cost_limit_;
    std::vector<Response> responses_;  ///< by material slot
    std::vector<bool> varies_;         ///< by material slot
    std::vector<bool> placed_;         ///< by material slot: its graph asks where a point lies
    Response held_out_;                ///< of what is matte, seen by the camera
};

/// Share of light that passes along a shadow ray, by channel.
V3d transmittance(const trace::Occlusion& occlusion);
/// The same, a light's shadow colour standing for what does not pass.
V3d shadowed(const Light& light, const trace::Occlusion& occlusion);
/// sum + weight * term, rounded once to single precision: how a branch joins its node.
inline V3f add_scaled(const V3f& sum, const V3f& weight, const V3f& term) {
    return V3f(V3d(sum) + V3d(weight) * V3d(term));
}

}  // namespace irt::shade
