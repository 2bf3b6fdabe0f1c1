// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "irt/shade/response.h"

namespace irt::shade {
namespace {

const V3d up{0, 0, 1};

V3d direction(double polar, double azimuth) {
    return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
            std::cos(polar)};
}

Material random_material(std::mt19937_64& random) {
    std::uniform_real_distribution<float> unit(0, 1);
    Material m;
    m.diffuse_color = {unit(random), unit(random), unit(random)};
    m.specular_color = {unit(random), unit(random), unit(random)};
    m.use_specular_workflow = unit(random) < 0.5f;
    m.metallic = unit(random);
    m.roughness = unit(random);
    m.ior = 1 + unit(random);
    return m;
}

TEST(Response, IsReciprocal) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> polar(0.01, 1.5), azimuth(0, 6.28);
    for (int trial = 0; trial < 1000; ++trial) {
        const Response r = make_response(random_material(random), 0.1);
        const V3d a = direction(polar(random), azimuth(random)),
                  b = direction(polar(random), azimuth(random));
        const V3d there = reflected_share(r, up, a, b) / a.z,
                  back = reflected_share(r, up, b, a) / b.z;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(there[c], back[c], 1e-12 * (1 + there[c]));
    }
}

/// Share of light from one direction that goes anywhere, by the midpoint rule.
double albedo(const Response& r, const V3d& to_light) {
    constexpr int steps = 400;
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double polar = (i + 0.5) / steps * std::numbers::pi / 2,
                         azimuth = (j + 0.5) / steps * 2 * std::numbers::pi;
            const V3d eye = direction(polar, azimuth);
            sum += reflected_share(r, up, to_light, eye).x / to_light.z * eye.z * std::sin(polar);
        }
    return sum * std::numbers::pi * std::numbers::pi / (steps * steps);
}

TEST(Response, MetalReflectsNoMoreThanItGets) {
    Material white;
    white.diffuse_color = {1, 1, 1};
    white.metallic = 1;
    for (const float roughness : {0.3f, 0.6f, 1.0f})
        for (const double polar : {0.1, 0.8, 1.3}) {
            white.roughness = roughness;
            const double share = albedo(make_response(white, 0.1), direction(polar, 0));
            EXPECT_LE(share, 1.001);
            EXPECT_GE(share, 0.3);
        }
}

/// UsdPreviewSurface weighs its diffuse term with the half vector's Fresnel, which takes from it
/// less than the specular term gives at grazing light: its formula, not ours, gains up to a
/// seventh.
TEST(Response, DielectricGainsNoMoreThanItsSpecificationDoes) {
    Material white;
    white.diffuse_color = {1, 1, 1};
    for (const float roughness : {0.3f, 0.6f, 1.0f})
        for (const double polar : {0.1, 0.8, 1.3}) {
            white.roughness = roughness;
            const double share = albedo(make_response(white, 0.1), direction(polar, 0));
            EXPECT_LE(share, 1.15);
            EXPECT_GE(share, 0.9);
        }
}

TEST(Response, LambertIsTheLimitWithoutSpecular) {
    Material m;
    m.diffuse_color = {0.5f, 0.5f, 0.5f};
    m.ior = 1;
    m.use_specular_workflow = true;
    Response r = make_response(m, 0.1);
    r.f90 = {0, 0, 0};
    EXPECT_NEAR(albedo(r, direction(0.7, 0)), 0.5, 1e-4);
}

TEST(Response, SnellsLawAndReflectionHold) {
    Material glass;
    glass.opacity = 0;
    glass.roughness = 0;
    glass.ior = 1.5f;
    const Response r = make_response(glass, 0.1);
    for (double angle = 0; angle < 1.57; angle += 0.05) {
        const V3d down = -direction(angle, 0.3);
        const Spawned s = spawn(r, down, up, up, true);
        EXPECT_NEAR(std::hypot(s.refract_direction.x, s.refract_direction.y) * 1.5, std::sin(angle),
                    1e-12);
        EXPECT_LT(s.refract_direction.z, 0);
        EXPECT_NEAR((s.reflect_direction - V3d(down.x, down.y, -down.z)).length(), 0, 1e-12);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(s.reflect_weight[c] + s.refract_weight[c], 1, 1e-12);
    }
}

TEST(Response, TotalReflectionStartsAtTheCriticalAngle) {
    Material glass;
    glass.opacity = 0;
    glass.roughness = 0.5f;  // too rough for a mirror ray of its own
    glass.ior = 1.5f;
    const Response r = make_response(glass, 0.1);
    const double critical = std::asin(1 / 1.5);
    const Spawned below = spawn(r, -direction(critical - 1e-7, 0), up, up, false);
    EXPECT_GT(below.refract_weight.x, 0);
    EXPECT_EQ(below.reflect_weight.x, 0);
    const Spawned above = spawn(r, -direction(critical + 1e-7, 0), up, up, false);
    EXPECT_EQ(above.refract_weight.x, 0);
    EXPECT_EQ(above.reflect_weight.x, 1);
}

TEST(Response, PresenceScalesAllOfASurfaceAndLetsTheRestBy) {
    Material m;
    m.emissive_color = {0.25f, 0.5f, 1};
    m.clearcoat = 0.5f;
    m.roughness = 0;
    const Response whole = make_response(m, 0.1);
    m.opacity = 0.25f;
    m.opacity_is_presence = true;
    const Response part = make_response(m, 0.1);
    const V3d in = direction(0.7, 0.3), out = direction(0.4, 2);
    EXPECT_EQ(part.emission, whole.emission * 0.25);
    EXPECT_NEAR(
        (reflected_share(part, up, in, out) - reflected_share(whole, up, in, out) * 0.25).length(),
        0, 1e-15);
    for (const bool front : {true, false}) {
        const Spawned all = spawn(whole, -in, up, up, front),
                      some = spawn(part, -in, up, up, front);
        EXPECT_EQ(some.refract_direction, -in);
        EXPECT_EQ(some.refract_weight, V3d(0.75, 0.75, 0.75));
        EXPECT_EQ(some.reflect_weight, all.reflect_weight * 0.25);
        EXPECT_EQ(some.reflect_direction, all.reflect_direction);
    }
    m.opacity = 0;
    EXPECT_TRUE(make_response(m, 0.1).invisible());
    m.opacity_is_presence = false;
    EXPECT_FALSE(make_response(m, 0.1).invisible());
}

TEST(Response, SpawnedRaysStayOnTheirSideOfTheGeometry) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> polar(0.01, 1.55), azimuth(0, 6.28);
    Material glass;
    glass.opacity = 0.2f;
    glass.roughness = 0;
    for (int trial = 0; trial < 10000; ++trial) {
        const V3d shading = direction(polar(random) * 0.9, azimuth(random));
        const V3d down = -direction(polar(random), azimuth(random));
        const Spawned s = spawn(make_response(glass, 0.1), down, shading, up, trial % 2 == 0);
        if (s.reflect_weight.x > 0) {
            EXPECT_GT(s.reflect_direction.z, 0);
        }
        if (s.refract_weight.x > 0) {
            EXPECT_LT(s.refract_direction.z, 0);
        }
    }
}

TEST(Response, CutOutsLetRaysPassAsTheyCame) {
    Material leaf;
    leaf.opacity = 0.2f;
    leaf.opacity_threshold = 0.5f;
    const V3d down = -direction(0.5, 0.5);
    const Spawned s = spawn(make_response(leaf, 0.1), down, up, up, true);
    EXPECT_EQ(s.refract_direction, down);
    EXPECT_EQ(s.refract_weight, V3d(1, 1, 1));
    EXPECT_EQ(s.reflect_weight, V3d(0, 0, 0));
}

/// The coat's lobe is that of a surface that has nothing else, times its share.
TEST(Response, ClearCoatIsAWhiteLobeOverTheOthers) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> polar(0.01, 1.5), azimuth(0, 6.28);
    for (int trial = 0; trial < 200; ++trial) {
        Material base = random_material(random), coated = base, alone;
        coated.clearcoat = 0.5f;
        coated.clearcoat_roughness = alone.roughness = 0.3f;
        alone.ior = base.ior;
        alone.diffuse_color = {0, 0, 0};
        const V3d a = direction(polar(random), azimuth(random)),
                  b = direction(polar(random), azimuth(random));
        const V3d gain = reflected_share(make_response(coated, 0.1), up, a, b) -
                         reflected_share(make_response(base, 0.1), up, a, b);
        const V3d expected = reflected_share(make_response(alone, 0.1), up, a, b) * 0.5;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(gain[c], expected[c], 1e-12 * (1 + expected[c]));
    }
}

/// At normal incidence a coat of index 1.5 reflects 4 %, and a rough base leaves the ray to it.
TEST(Response, ClearCoatMirrorsByItsFresnel) {
    Material m;
    m.clearcoat = 0.75f;
    m.roughness = 1;
    const Spawned s = spawn(make_response(m, 0.1), -up, up, up, true);
    EXPECT_EQ(s.refract_weight, V3d(0, 0, 0));
    EXPECT_EQ(s.reflect_direction, up);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(s.reflect_weight[c], 0.75 * 0.04, 1e-15);
    m.clearcoat_roughness = 0.5f;
    EXPECT_EQ(spawn(make_response(m, 0.1), -up, up, up, true).reflect_weight, V3d(0, 0, 0));
}

TEST(Response, UncoatedMaterialsHaveNoCoat) {
    Material m;
    m.roughness = 0;
    const Response r = make_response(m, 0.1);
    EXPECT_FALSE(r.coat_mirror);
    EXPECT_EQ(spawn(r, -up, up, up, true).reflect_weight, fresnel(r, 1));
}

}  // namespace
}  // namespace irt::shade
