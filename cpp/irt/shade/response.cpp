// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/response.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace irt::shade {

namespace {

const V3d one{1, 1, 1};

V3d mix(const V3d& a, const V3d& b, double t) { return a * (1 - t) + b * t; }

V3d mirrored(const V3d& direction, const V3d& normal) {
    return direction - normal * (2 * direction.dot(normal));
}

/// Snell's law; `eta` is the index of the near side over that of the far side. Zero on total
/// internal reflection.
V3d refracted(const V3d& direction, const V3d& normal, double eta) {
    const double cosine = -direction.dot(normal);
    const double squared = 1 - eta * eta * (1 - cosine * cosine);
    if (squared <= 0) return {0, 0, 0};
    return direction * eta + normal * (eta * cosine - std::sqrt(squared));
}

/// Schlick's (1 - c)^5.
double schlick(double c) {
    const double m = std::clamp(1 - c, 0.0, 1.0);
    const double m2 = m * m;
    return m2 * m2 * m;
}

/// What the clear coat reflects.
double coat_fresnel(const Response& response, double c) {
    return response.coat * (response.coat_f0 + (1 - response.coat_f0) * schlick(c));
}

/// GGX distribution times Smith's height-correlated masking over 4 (n.l) (n.e).
double ggx(double alpha, double nh, double nl, double ne) {
    const double a2 = alpha * alpha;
    const double d = nh * nh * (a2 - 1) + 1;
    const double distribution = a2 / (std::numbers::pi * d * d);
    const double visibility =
        0.5 / (nl * std::sqrt(ne * ne * (1 - a2) + a2) + ne * std::sqrt(nl * nl * (1 - a2) + a2));
    return distribution * visibility;
}

}  // namespace

Response make_response(const SurfaceValues& material, double mirror_roughness) {
    Response r;
    const V3d& color = material.diffuse_color;
    const auto alpha = [](double roughness) { return std::max(roughness * roughness, min_alpha); };
    r.base_color = color;
    (is_presence(material) ? r.presence : r.opacity) = effective_opacity(material);
    r.ior = material.ior;
    r.emission = material.emissive_color * r.presence;
    r.transmission = material.transmission_color;
    r.alpha = alpha(material.roughness);
    r.mirror = material.roughness <= mirror_roughness;
    const double s = (1 - r.ior) / (1 + r.ior);
    if (material.use_specular_workflow) {
        r.f0 = material.specular_color;
        r.f90 = one;
        r.diffuse = color * r.opacity;
    } else {
        const double metallic = material.metallic;
        r.f90 = mix(one, color, metallic);
        r.f0 = mix(r.f90 * (s * s), r.f90, metallic);
        r.diffuse = color * (r.opacity * (1 - metallic));
    }
    r.coat = material.clearcoat;
    r.coat_f0 = s * s;
    r.coat_alpha = alpha(material.clearcoat_roughness);
    r.coat_mirror = r.coat > 0 && material.clearcoat_roughness <= mirror_roughness;
    return r;
}

V3d fresnel(const Response& response, double c) {
    return mix(response.f0, response.f90, schlick(c));
}

V3d reflected_share(const Response& response, const V3d& normal, const V3d& to_light,
                    const V3d& to_eye, double diffuse, double specular) {
    const double nl = normal.dot(to_light), ne = normal.dot(to_eye);
    if (!(nl > 0 && ne > 0)) return {0, 0, 0};
    const V3d half = normalized(to_light + to_eye);
    const double nh = std::min(normal.dot(half), 1.0);
    const double c = std::max(to_eye.dot(half), 0.0);
    const V3d f = fresnel(response, c);
    const V3d lambert = response.diffuse * (one - f) * std::numbers::inv_pi;
    V3d share = lambert * diffuse + f * (ggx(response.alpha, nh, nl, ne) * specular);
    if (response.coat > 0)
        share += V3d(coat_fresnel(response, c) * ggx(response.coat_alpha, nh, nl, ne) * specular);
    return share * (nl * response.presence);
}

Response black_response() {
    Response r;
    r.base_color = r.diffuse = r.f0 = r.f90 = r.emission = r.transmission = V3d(0, 0, 0);
    r.alpha = r.coat_alpha = 1;
    return r;
}

Spawned spawn(const Response& response, const V3d& direction, const V3d& shading,
              const V3d& geometric, bool front) {
    Spawned out;
    // What goes by; never together with what is refracted.
    const double past = 1 - response.presence;
    if (past > 0) {
        out.refract_weight = one * past;
        out.refract_direction = direction;
    }
    if (response.invisible()) return out;
    const double through = 1 - response.opacity;
    if (!response.mirror && !response.coat_mirror && !(through > 0)) return out;
    const double cosine = std::max(-direction.dot(shading), 0.0);
    V3d f = fresnel(response, cosine);
    bool total = false;
    if (through > 0) {
        const double eta = front ? 1 / response.ior : response.ior;
        V3d bent = refracted(direction, shading, eta);
        // A shading normal may bend a ray back out of the surface; the geometric one cannot.
        if (bent != V3d(0, 0, 0) && bent.dot(geometric) >= 0)
            bent = refracted(direction, geometric, eta);
        total = bent == V3d(0, 0, 0);
        if (total) {
            f = one;
        } else {
            // Schlick takes the angle on the thinner side.
            if (eta > 1) f = fresnel(response, -bent.dot(shading));
            out.refract_weight = (one - f) * response.transmission * through;
            out.refract_direction = normalized(bent);
        }
    }
    if (response.mirror || response.coat_mirror || total) {
        out.reflect_weight = response.mirror ? f : (total ? one * through : V3d(0, 0, 0));
        if (response.coat_mirror && !total)
            out.reflect_weight += V3d(coat_fresnel(response, cosine));
        out.reflect_weight *= response.presence;
        V3d back = mirrored(direction, shading);
        if (back.dot(geometric) <= 0) back = mirrored(direction, geometric);
        out.reflect_direction = normalized(back);
    }
    return out;
}

}  // namespace irt::shade
