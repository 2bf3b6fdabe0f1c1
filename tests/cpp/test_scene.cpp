// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "irt/scene/compile.h"
#include "irt/scene/scene.h"

namespace irt {
namespace {

M44d translation(double x, double y, double z) {
    M44d m;
    m[3][0] = x;
    m[3][1] = y;
    m[3][2] = z;
    return m;
}

ChangeSet one_ball() {
    ChangeSet changes;
    changes.materials["/m"] = Material{};
    changes.objects["/ball"] = Object{Quadric{}, translation(1, 2, 3), "/m"};
    return changes;
}

std::shared_ptr<Mesh> quad() {
    auto mesh = std::make_shared<Mesh>();
    mesh->points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh->face_vertex_counts = {4};
    mesh->face_vertex_indices = {0, 1, 2, 3};
    return mesh;
}

V3f front_of(const Triangles& t) {
    const auto& [a, b, c] = t.triangles[0];
    return (t.points[b] - t.points[a]).cross(t.points[c] - t.points[a]);
}

TEST(Scene, EqualRecordsAreNoChange) {
    Scene scene({0, 0, 0});
    EXPECT_FALSE(scene.apply(one_ball()).empty());
    EXPECT_TRUE(scene.apply(one_ball()).empty());
    EXPECT_EQ(scene.version(), 1u);
}

TEST(Scene, NegativeZeroIsAChange) {
    Scene scene({0, 0, 0});
    ChangeSet changes = one_ball();
    scene.apply(changes);
    changes.objects["/ball"]->world_from_object[0][1] = -0.0;
    EXPECT_EQ(scene.apply(changes).geometry.size(), 1u);
}

TEST(Scene, RefusedChangesLeaveNoTrace) {
    Scene scene({0, 0, 0});
    scene.apply(one_ball());
    ChangeSet bad;
    bad.materials["/n"] = Material{};
    bad.objects["/ball"] = std::nullopt;
    bad.objects["/other"] = Object{Quadric{}, M44d(), "/nowhere"};
    EXPECT_THROW(scene.apply(bad), std::invalid_argument);
    EXPECT_TRUE(scene.all_objects()[0].live);
    EXPECT_EQ(scene.materials().size(), 1u);
    EXPECT_EQ(scene.version(), 1u);
}

TEST(Scene, RemovingAMaterialInUseIsRefused) {
    Scene scene({0, 0, 0});
    scene.apply(one_ball());
    ChangeSet bad;
    bad.materials["/m"] = std::nullopt;
    EXPECT_THROW(scene.apply(bad), std::invalid_argument);
    bad.objects["/ball"] = std::nullopt;
    EXPECT_NO_THROW(scene.apply(bad));
}

TEST(Scene, SlotsBelongToTheirPaths) {
    Scene scene({0, 0, 0});
    scene.apply(one_ball());
    ChangeSet away, others = one_ball();
    away.objects["/ball"] = std::nullopt;
    scene.apply(away);
    others.objects["/another"] = others.objects["/ball"];
    scene.apply(others);
    EXPECT_EQ(scene.all_objects()[0].path, "/ball");
    EXPECT_EQ(scene.all_objects()[1].path, "/another");
    EXPECT_LT(scene.all_objects()[1].rank, scene.all_objects()[0].rank);
}

TEST(Scene, IdsArePublishedHashes) {
    Scene scene({0, 0, 0});
    ChangeSet changes = one_ball();
    changes.objects["hello"] = changes.objects["/ball"];
    scene.apply(changes);
    // MurmurHash3_x86_32("hello", seed 0), a published test vector.
    EXPECT_EQ(scene.all_objects()[1].id, 0x248bfa47u);
}

TEST(Scene, LightsWithoutEnergyAreAbsent) {
    Scene scene({0, 0, 0});
    ChangeSet changes;
    Light dark;
    dark.energy = {0, 0, 0};
    changes.lights = {{"/b", Light{}}, {"/c", dark}, {"/a", Light{}}};
    scene.apply(changes);
    ASSERT_EQ(scene.lights().size(), 2u);
    EXPECT_EQ(scene.lights()[0].path, "/a");
    EXPECT_EQ(scene.lights()[1].path, "/b");
}

TEST(Compile, InverseUndoesItsMatrix) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> entry(-1, 1), exponent(-6, 9);
    for (int trial = 0; trial < 1000; ++trial) {
        M44d m;
        const double scale = std::pow(10.0, exponent(random));
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m[i][j] = scale * entry(random);
        for (int j = 0; j < 3; ++j) m[3][j] = scale * entry(random);
        const V3d p{scale * entry(random), scale * entry(random), scale * entry(random)};
        const V3d back = transform_point(checked_inverse(m, "/p"), transform_point(m, p));
        // Of 1000 random matrices the worst conditioned cost some 10^4 of double's 10^16.
        EXPECT_LT((back - p).length(), 1e-7 * scale);
    }
}

TEST(Compile, SingularMatricesAreRefusedByName) {
    M44d flat;
    flat[2][2] = 0;
    M44d infinite;
    infinite[3][0] = std::numeric_limits<double>::infinity();
    M44d line;  // rank 1 to rounding, with cofactors and determinant of noise
    const double entries[3][3] = {
        {-0.08385147001587978, -0.18813220162624242, -0.041359754679679915},
        {-0.08639601430949574, -0.1938412335609575, -0.04261485167124852},
        {0.054208142497613375, 0.12162335606297336, 0.02673817733806962}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) line[i][j] = entries[i][j];
    for (const M44d& m : {flat, infinite, line}) {
        try {
            checked_inverse(m, "/World/Flat");
            FAIL();
        } catch (const std::invalid_argument& error) {
            EXPECT_EQ(std::string(error.what()).rfind("/World/Flat: ", 0), 0u);
        }
    }
}

TEST(Compile, FrontStaysTheFront) {
    auto mesh = quad();
    M44d mirror;
    mirror[0][0] = -1;
    EXPECT_GT(front_of(*triangulate(mesh, M44d(), "/q")).z, 0);
    EXPECT_GT(front_of(*triangulate(mesh, mirror, "/q")).z, 0);
    mesh->left_handed = true;
    EXPECT_LT(front_of(*triangulate(mesh, M44d(), "/q")).z, 0);
    EXPECT_LT(front_of(*triangulate(mesh, mirror, "/q")).z, 0);
}

TEST(Compile, ConcavePolygonsKeepTheirArea) {
    // A U, an arrow and a dart: the triangles cover the polygon once, wound alike.
    const std::vector<std::vector<V3f>> polygons = {
        {{0, 0, 1}, {3, 0, 1}, {3, 3, 1}, {2, 3, 1}, {2, 1, 1}, {1, 1, 1}, {1, 3, 1}, {0, 3, 1}},
        {{7, 0, 0}, {7, 5, 5}, {7, 5, 6}, {7, 0, 2}, {7, -5, 6}, {7, -5, 5}},
        {{0, 0, 0}, {2, 1, 0}, {0, 4, 0}, {1, 1, 0}},
    };
    for (const std::vector<V3f>& points : polygons) {
        auto mesh = std::make_shared<Mesh>();
        mesh->points = points;
        mesh->face_vertex_counts.push_back(static_cast<std::int32_t>(points.size()));
        V3f expected{0, 0, 0}, sum{0, 0, 0};
        float total = 0;
        for (std::size_t k = 0; k < points.size(); ++k) {
            mesh->face_vertex_indices.push_back(static_cast<std::int32_t>(k));
            expected += points[k].cross(points[(k + 1) % points.size()]);
        }
        const auto cut = triangulate(mesh, M44d(), "/p");
        EXPECT_EQ(cut->triangles.size(), points.size() - 2);
        for (const auto& [a, b, c] : cut->triangles) {
            const V3f twice = (points[b] - points[a]).cross(points[c] - points[a]);
            sum += twice;
            total += twice.length();
        }
        EXPECT_NEAR(sum.length(), expected.length(), 1e-4f);
        EXPECT_NEAR(total, expected.length(), 1e-4f) << "triangles overlap or face both ways";
    }
}

TEST(Compile, StretchedMatricesAreNotSingular) {
    // A rotation stretched along world axes: nearly parallel rows, perfectly good inverse.
    M44d m;
    const double c = std::sqrt(0.5);
    const double rotation[3][3] = {{c, c, 0}, {-c, c, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) m[i][j] = rotation[i][j] * (j == 0 ? 1e10 : 1);
    EXPECT_NO_THROW((void)checked_inverse(m, "/p"));
}

TEST(Compile, LastColumnsMayBeOffByRounding) {
    M44d m;
    m[3][3] = 0.9999999999999999;
    EXPECT_NO_THROW((void)checked_inverse(m, "/p"));
    m[3][3] = 0.5;
    EXPECT_THROW((void)checked_inverse(m, "/p"), std::invalid_argument);
}

TEST(Compile, BrokenTopologyIsRefused) {
    const auto refused = [](const std::shared_ptr<Mesh>& mesh) {
        EXPECT_THROW((void)triangulate(mesh, M44d(), "/q"), std::invalid_argument);
    };
    auto mesh = quad();
    mesh->face_vertex_indices[2] = 4;
    refused(mesh);
    mesh = quad();
    mesh->face_vertex_counts = {5};
    refused(mesh);
    mesh = quad();
    mesh->points[1].y = std::numeric_limits<float>::quiet_NaN();
    refused(mesh);
    mesh = quad();
    mesh->normals.assign(1, V3f(0, 0, 1));
    mesh->normals_interpolation = Interpolation::Vertex;
    refused(mesh);
}

TEST(Compile, ShadowDepthIsTintQuantised) {
    Material m;
    EXPECT_EQ(shadow_depth(m).rgb[0], trace::depth_opaque);
    m.opacity = 0;
    m.diffuse_color = {1, 0.5f, 0};
    const trace::OpticalDepth tinted{{0, 4096, trace::depth_opaque}};
    EXPECT_EQ(shadow_depth(m), tinted);
    m.opacity = 0.2f;
    m.opacity_threshold = 0.5f;
    EXPECT_EQ(shadow_depth(m), trace::OpticalDepth{}) << "a cut-out is absent";
}

}  // namespace
}  // namespace irt
