// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface's response to delta lights, and its mirror and refracted rays
// (docs/shading.md; UsdPreviewSurface Specification 2.6; Walter et al. 2007; Heitz 2014).
#pragma once

#include "irt/math/vec.h"
#include "irt/scene/records.h"

namespace irt::shade {

/// A material's values as the formulas want them. Pure function of those.
struct Response {
    V3d base_color;      ///< diffuseColor
    V3d diffuse;         ///< Lambert reflectance, times opacity
    V3d f0, f90;         ///< Schlick's Fresnel at normal and at grazing incidence
    V3d emission;        ///< times presence
    V3d transmission;    ///< what tints a refracted ray
    double alpha = 0;    ///< GGX roughness: roughness squared, at least min_alpha
    double coat = 0;     ///< share of the clear coat, a white lobe over the others
    double coat_f0 = 0;  ///< its Fresnel at normal incidence; at grazing incidence it is 1
    double coat_alpha = 0;
    double presence = 1;  ///< share of the surface that is there; rays pass the rest as they are
    double opacity = 1;   ///< of what is there
    double ior = 1;
    bool mirror = false;       ///< spawns a mirror ray
    bool coat_mirror = false;  ///< its clear coat does

    [[nodiscard]] bool invisible() const { return presence == 0; }
};

/// Below this GGX's peak leaves the range where 32-bit films resolve it; UsdPreviewSurface's own
/// implementation clamps roughness to 0.001, this is that of roughness 0.01.
inline constexpr double min_alpha = 1e-4;

Response make_response(const SurfaceValues& material, double mirror_roughness);

/// A surface that returns, emits and passes nothing.
Response black_response();

/// Schlick's Fresnel reflectance for the cosine `c` between half vector and view.
V3d fresnel(const Response& response, double c);

/// BRDF times cosine for unit `normal`, `to_light`, `to_eye`; both directions in the normal's
/// hemisphere, else 0.
/// `diffuse` and `specular` scale what a light adds by the two.
V3d reflected_share(const Response& response, const V3d& normal, const V3d& to_light,
                    const V3d& to_eye, double diffuse = 1, double specular = 1);

/// How a surface passes rays on. A weight of 0 spawns no ray, and its direction is not set.
struct Spawned {
    V3d reflect_weight{0, 0, 0}, refract_weight{0, 0, 0};
    V3d reflect_direction, refract_direction;  ///< unit
};

/// `direction` (unit) travels towards the surface; `shading` and `geometric` are unit normals on
/// the side it comes from; `front`: that side is the outside.
Spawned spawn(const Response& response, const V3d& direction, const V3d& shading,
              const V3d& geometric, bool front);

}  // namespace irt::shade
