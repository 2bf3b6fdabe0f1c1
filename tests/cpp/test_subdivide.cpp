// SPDX-License-Identifier: Apache-2.0
// Subdivision against closed forms: limit masks, creases, face-varying rules, what stays as it is.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "irt/scene/equality.h"
#include "irt/scene/subdivide.h"

namespace irt {
namespace {

Mesh cube() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.points.emplace_back(i & 4 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 1 ? 1.f : -1.f);
    mesh.face_vertex_counts.assign(6, 4);
    mesh.face_vertex_indices = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1,
                                2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
    return mesh;
}

/// A square of `n` by `n` squares in z = 0, bent up by `height` at its centre.
Mesh grid(int n, float height) {
    Mesh mesh;
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x)
            mesh.points.emplace_back(static_cast<float>(x), static_cast<float>(y),
                                     2 * x == n && 2 * y == n ? height : 0.f);
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const int corner = y * (n + 1) + x;
            mesh.face_vertex_counts.push_back(4);
            for (const int i : {corner, corner + 1, corner + n + 2, corner + n + 1})
                mesh.face_vertex_indices.push_back(i);
        }
    return mesh;
}

Mesh octahedron() {
    Mesh mesh;
    mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.face_vertex_counts.assign(8, 3);
    mesh.face_vertex_indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    return mesh;
}

Subdivision level(int n, SubdivisionScheme scheme = SubdivisionScheme::CatmullClark) {
    Subdivision rules;
    rules.scheme = scheme;
    rules.level = n;
    return rules;
}

/// Halstead, Kass and DeRose 1993: (n² v + 4 Σ edges + Σ opposite corners) / (n (n + 5)).
TEST(Subdivide, CatmullClarkLimitPositions) {
    for (int n = 1; n <= 3; ++n) {
        const Mesh fine = subdivide(cube(), level(n));
        EXPECT_EQ(fine.face_vertex_counts.size(), 6u << (2 * n));
        EXPECT_EQ(fine.points[0], V3f(-0.5f, -0.5f, -0.5f));
        EXPECT_NEAR((fine.normals[0] - V3f(-1, -1, -1) / std::sqrt(3.f)).length(), 0, 1e-6);
        // n = 4, v = (2, 2, 1), all others in the plane: 16 / 36.
        EXPECT_NEAR(subdivide(grid(4, 1), level(n)).points[12].z, 16.0 / 36, 1e-7);
    }
}

/// Loop's weights at valence 4: beta = (5/8 - (3/8 + cos(pi/2)/4)²) / 4, limit 1 / (1 + 8/3 n beta)
/// of the vertex itself.
TEST(Subdivide, LoopLimitPositions) {
    const double beta = (5.0 / 8 - 9.0 / 64) / 4;
    const double limit = 1 / (1 + 8.0 / 3 * 4 * beta);  // the neighbours sum to nothing
    for (int n = 1; n <= 3; ++n) {
        const Mesh fine = subdivide(octahedron(), level(n, SubdivisionScheme::Loop));
        EXPECT_EQ(fine.face_vertex_counts.size(), 8u << (2 * n));
        EXPECT_NEAR(fine.points[0].x, limit, 1e-6);
        EXPECT_NEAR(std::fabs(fine.normals[0].x), 1, 1e-6);
    }
    EXPECT_THROW(subdivide(cube(), level(1, SubdivisionScheme::Loop)), std::invalid_argument);
}

TEST(Subdivide, BilinearKeepsTheShape) {
    const Mesh fine = subdivide(cube(), level(2, SubdivisionScheme::Bilinear));
    EXPECT_EQ(fine.normals_interpolation, Interpolation::None);
    for (const V3f& p : fine.points)
        EXPECT_EQ(std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}), 1.0f);
}

TEST(Subdivide, InfinitelySharpEdgesStayStraight) {
    const Mesh cage = cube();
    Subdivision rules = level(3);
    for (int face = 0; face < 6; ++face)
        for (int k = 0; k <= 4; ++k)
            rules.crease_indices.push_back(
                cage.face_vertex_indices[static_cast<std::size_t>(4 * face + k % 4)]);
    rules.crease_lengths.assign(6, 5);
    rules.crease_sharpnesses.assign(6, 10);
    const Mesh fine = subdivide(cage, rules);
    for (const V3f& p : fine.points)
        EXPECT_NEAR(std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}), 1, 1e-6);
    // Normals are those of the faces, on either side of every edge.
    EXPECT_EQ(fine.normals_interpolation, Interpolation::FaceVarying);
    for (const V3f& n : fine.normals)
        EXPECT_NEAR(std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)}), 1, 1e-6);
}

TEST(Subdivide, PrimvarsFollowTheirRules) {
    Mesh cage = grid(4, 1);
    Primvar linear{"linear", Interpolation::Varying, 1, {}, {}}, smooth = linear;
    for (const V3f& p : cage.points) linear.values.push_back(p.z);
    smooth = linear;
    smooth.name = "smooth";
    smooth.interpolation = Interpolation::Vertex;
    Primvar whole{"whole", Interpolation::Uniform, 1, {}, {}}, corners = whole;
    for (int i = 0; i < 16; ++i) whole.values.push_back(static_cast<float>(i));
    Primvar st{"st", Interpolation::FaceVarying, 2, {}, {}};
    for (const V3f& p : cage.points) {
        st.values.push_back(p.x);
        st.values.push_back(p.y);
    }
    st.indices = cage.face_vertex_indices;
    cage.primvars = {linear, smooth, st, whole};
    cage.face_materials.assign(16, -1);
    cage.face_materials[5] = 0;
    Subdivision rules = level(2);
    rules.face_varying = FaceVaryingRule::All;
    const Mesh fine = subdivide(cage, rules);
    EXPECT_EQ(fine.primvars[0].values[12], 1.0f);
    EXPECT_NEAR(fine.primvars[1].values[12], 16.0 / 36, 1e-7);
    // Linear all over: the square stays a square, its corners too.
    float most = 0;
    for (const float v : fine.primvars[2].values) most = std::max(most, v);
    EXPECT_EQ(most, 4.0f);
    EXPECT_EQ(fine.primvars[3].indices.size(), 256u);
    EXPECT_EQ(std::count(fine.primvars[3].indices.begin(), fine.primvars[3].indices.end(), 5), 16);
    EXPECT_EQ(std::count(fine.face_materials.begin(), fine.face_materials.end(), 0), 16);
}

TEST(Subdivide, HolesShapeTheSurfaceAndAreLeftOut) {
    Subdivision rules = level(1);
    rules.hole_indices = {0};
    const Mesh fine = subdivide(cube(), rules), whole = subdivide(cube(), level(1));
    EXPECT_EQ(fine.face_vertex_counts.size(), 20u);
    EXPECT_EQ(fine.points[0], whole.points[0]);
    rules.level = 0;
    EXPECT_EQ(subdivide(cube(), rules).face_vertex_counts.size(), 5u);
}

TEST(Subdivide, KeptTopologyGivesWhatANewOneGives) {
    Subdivider kept(level(2));
    Mesh cage = cube();
    for (int i = 0; i < 3; ++i) {
        cage.points[0].x -= 0.25f;
        EXPECT_TRUE(same(kept.refine(cage), subdivide(cage, level(2))));
    }
    EXPECT_TRUE(same(kept.refine(grid(2, 1)), subdivide(grid(2, 1), level(2))));
}

TEST(Subdivide, BrokenTopologyIsRefinedOrRefused) {
    Mesh fan = cube();  // three faces on one edge, and a face that repeats a point
    for (const int i : {0, 1, 5, 6, 0, 1, 1, 2}) fan.face_vertex_indices.push_back(i);
    fan.face_vertex_counts.insert(fan.face_vertex_counts.end(), 2, 4);
    fan.points.emplace_back(9.f, 9.f, 9.f);  // of no face
    const Mesh fine = subdivide(fan, level(2));
    for (const std::int32_t i : fine.face_vertex_indices) {
        const V3f& p = fine.points[static_cast<std::size_t>(i)];
        EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    }
    Subdivision rules = level(1);
    rules.corner_indices = {99};
    rules.corner_sharpnesses = {1};
    EXPECT_THROW(subdivide(cube(), rules), std::invalid_argument);
}

TEST(Subdivide, TheCageHasSmoothNormals) {
    const Mesh cage = subdivide(cube(), level(0));
    EXPECT_EQ(cage.points.size(), 8u);
    EXPECT_NEAR((cage.normals[0] - V3f(-1, -1, -1) / std::sqrt(3.f)).length(), 0, 1e-6);
}

}  // namespace
}  // namespace irt
