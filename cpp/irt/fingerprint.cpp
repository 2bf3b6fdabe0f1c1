// SPDX-License-Identifier: Apache-2.0
#include "irt/fingerprint.h"

#define XXH_INLINE_ALL
#include <oneapi/tbb/version.h>
#include <xxhash.h>

#include <Imath/ImathConfig.h>

#include <cstdio>
#include <vector>

#include "irt/math/float_state.h"
#include "irt/math/libm.h"
#include "irt/renderer.h"
#include "irt/scene/subdivide.h"

namespace irt {

namespace {

/// Noise of a multiplicative congruence, as sRGB.
std::shared_ptr<const Texture> fixed_texture() {
    constexpr int side = 13;
    const std::shared_ptr<std::byte[]> texels(new std::byte[side * side * 4]);
    std::uint32_t random = 1;
    for (int i = 0; i < side * side * 4; ++i) {
        random = random * 1664525u + 1013904223u;
        texels[i] = static_cast<std::byte>(random >> 24);
    }
    Tile tile;
    tile.levels.push_back({side, side, {texels, texels.get()}});
    return std::make_shared<const Texture>(std::vector<Tile>{tile}, Transfer::Srgb,
                                           std::array<double, 9>{0.9, 0.1, 0, 0, 1, 0, 0.1, 0, 0.9},
                                           false);
}

/// Its colour, roughness and normals by a texture, turned and repeated.
Material textured() {
    Material material;
    ShadeNode st, turned, texel;
    st.op = Op::Primvar;
    st.primvar = "st";
    turned.op = Op::Transform2d;
    turned.inputs[0] = 0;
    turned.constants[1] = {3, 2, 0, 0};
    turned.constants[2] = {20, 0, 0, 0};
    texel.op = Op::Texture;
    texel.inputs[0] = 1;
    texel.texture = fixed_texture();
    material.nodes = {st, turned, texel};
    for (const SurfaceInput input : {SurfaceInput::DiffuseColor, SurfaceInput::Normal})
        material.connected[static_cast<std::size_t>(input)] = {2, Connection::rgb};
    material.connected[static_cast<std::size_t>(SurfaceInput::Roughness)] = {2, 3};
    return material;
}

/// The limit surface of a creased pyramid: OpenSubdiv's masks of irregular vertices.
std::shared_ptr<const Mesh> subdivided() {
    Subdivision rules;
    rules.level = 2;
    rules.crease_indices = {0, 1};
    rules.crease_lengths = {2};
    rules.crease_sharpnesses = {1.5f};
    Mesh cage;
    cage.points = {{0, 1, 0}, {-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
    cage.face_vertex_counts = {3, 3, 3, 3, 4};
    cage.face_vertex_indices = {0, 2, 1, 0, 3, 2, 0, 4, 3, 0, 1, 4, 1, 2, 3, 4};
    return std::make_shared<const Mesh>(Subdivider(rules).refine(cage));
}

/// Glass, mirror and textured objects of four kinds under two lights: every path of the
/// arithmetic.
ChangeSet fixed_scene() {
    ChangeSet changes;
    Material mirror, glass;
    mirror.metallic = 1;
    mirror.roughness = 0.05f;
    glass.opacity = 0.15f;
    glass.diffuse_color = {0.9f, 0.7f, 0.8f};
    glass.roughness = 0;
    changes.materials = {{"/mirror", mirror}, {"/glass", glass}, {"/ground", textured()}};

    const auto place = [](double x, double y, double z) {
        M44d m;
        m[3][0] = x;
        m[3][1] = y;
        m[3][2] = z;
        return m;
    };
    Quadric sphere, cone;
    cone.kind = QuadricKind::Cone;
    auto ground = std::make_shared<Mesh>();
    ground->points = {{-9, -1, -9}, {9, -1, -9}, {9, -1.3f, 9}, {-9, -0.9f, 9}};
    ground->face_vertex_counts = {4};
    ground->face_vertex_indices = {3, 2, 1, 0};
    ground->primvars = {{"st", Interpolation::Vertex, 2, {0, 0, 1, 0, 1, 1, 0, 1}, {}}};
    changes.objects["/ball"] = Object{sphere, place(-1, 0.1, -6), "/mirror"};
    changes.objects["/cone"] = Object{cone, place(1.2, 0.2, -5), "/glass"};
    changes.objects["/ground"] = Object{std::shared_ptr<const Mesh>(ground), M44d(), "/ground"};

    changes.objects["/pyramid"] = Object{subdivided(), place(0.3, -0.9, -7), "/mirror"};

    Light sun, lamp;
    sun.direction = {0.3, -1, -0.4};
    lamp.kind = LightKind::Point;
    lamp.position = {2, 4, -3};
    lamp.energy = {20, 18, 15};
    changes.lights = {{"/sun", sun}, {"/lamp", lamp}};
    return changes;
}

}  // namespace

std::string numeric_fingerprint(const std::string& isa) {
    const FloatState ieee;
    XXH3_state_t state;
    XXH3_64bits_reset(&state);

    RendererOptions options;
    options.isa = isa;
    options.threads = 1;
    ViewSettings settings;
    settings.width = settings.height = 48;
    settings.samples = 2;
    settings.aovs = {film::Aov::Depth, film::Aov::Normal, film::Aov::Position};
    Renderer renderer(Camera{}, settings, options);
    cells::Control control;
    renderer.update(fixed_scene(), {{std::nullopt, false}}, control);
    const film::Film& film = renderer.film();
    const std::size_t pixels = 48 * 48;
    XXH3_64bits_update(&state, film.beauty(), pixels * 4 * sizeof(float));
    XXH3_64bits_update(&state, film.depth(), pixels * sizeof(float));
    XXH3_64bits_update(&state, film.vectors(film::Aov::Normal), pixels * sizeof(V3f));
    XXH3_64bits_update(&state, film.vectors(film::Aov::Position), pixels * sizeof(V3f));

    std::vector<double> values;
    for (int i = 1; i <= 1024; ++i) {
        values.push_back(libm::log2(i / 1024.0));
        values.push_back(libm::exp2(-i / 37.0));
        values.push_back(libm::pow(i / 1024.0, 2.4));
        values.push_back(libm::exp(-i / 37.0));
        values.push_back(libm::log(i / 37.0));
        values.push_back(libm::sin(i / 652.0));
        values.push_back(libm::cos(i / 652.0));
        values.push_back(libm::asin(i / 1024.0));
        values.push_back(libm::acos(i / 1024.0));
        values.push_back(libm::atan2(i / 37.0, 1.0));
    }
    XXH3_64bits_update(&state, values.data(), values.size() * sizeof(double));

    char text[17];
    std::snprintf(text, sizeof text, "%016llx",
                  static_cast<unsigned long long>(XXH3_64bits_digest(&state)));
    return text;
}

std::map<std::string, std::string> versions() {
    return {{"irt", IRT_VERSION},
            {"Embree", trace::embree_version()},
            {"TBB", std::to_string(TBB_VERSION_MAJOR) + "." + std::to_string(TBB_VERSION_MINOR)},
            {"Imath", IMATH_VERSION_STRING},
            {"compiler", __VERSION__}};
}

}  // namespace irt
