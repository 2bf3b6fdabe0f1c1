// SPDX-License-Identifier: Apache-2.0
// Subdivision against closed forms: limit masks, creases, face-varying rules, what stays as it is.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
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
}

/// What is wrong with one crease or corner leaves that one out; the others stay.
TEST(Subdivide, BadCreasesAndCornersAreLeftOut) {
    Subdivision good = level(2);
    good.crease_indices = {0, 1, 3};
    good.crease_lengths = {3};
    good.crease_sharpnesses = {2.5f, 10};
    good.corner_indices = {7};
    good.corner_sharpnesses = {10};
    const Mesh expected = subdivide(cube(), good);
    EXPECT_FALSE(same(expected, subdivide(cube(), level(2))));

    Subdivision rules = good;
    rules.crease_indices = {0, 99, 0, 1, 3, -1, 4};
    rules.crease_lengths = {2, 3, 2};
    rules.crease_sharpnesses = {5, 2.5f, 10, 5};  // by edge
    rules.corner_indices = {99, 7};
    rules.corner_sharpnesses = {1, 10};
    Subdivider subdivider(rules);
    EXPECT_TRUE(same(subdivider.refine(cube()), expected));
    EXPECT_EQ(subdivider.left_out().size(), 3u);

    rules = good;
    rules.crease_indices.insert(rules.crease_indices.end(), {0, 7});  // a diagonal of the cube
    rules.crease_lengths.push_back(2);
    rules.crease_sharpnesses.push_back(4);
    Subdivider without_diagonal(rules);
    EXPECT_TRUE(same(without_diagonal.refine(cube()), expected));
    EXPECT_EQ(without_diagonal.left_out().size(), 1u);

    rules = good;
    rules.crease_lengths = {7};
    good.crease_indices.clear();
    good.crease_lengths.clear();
    good.crease_sharpnesses.clear();
    Subdivider without_creases(rules);
    EXPECT_TRUE(same(without_creases.refine(cube()), subdivide(cube(), good)));
    EXPECT_EQ(without_creases.left_out().size(), 1u);
}

/// An infinitely sharp corner stays where it is; a semi-sharp one lies between.
TEST(Subdivide, CornersAreAsSharpAsTheySay) {
    double before = -0.5;
    for (const float sharpness : {0.25f, 1.f, 2.5f, 10.f}) {
        Subdivision rules = level(3);
        rules.corner_indices = {0};
        rules.corner_sharpnesses = {sharpness};
        const Mesh fine = subdivide(cube(), rules);
        EXPECT_LT(fine.points[0].x, before);
        EXPECT_NEAR(fine.points[0].x, fine.points[0].y, 1e-6);
        before = double(fine.points[0].x);
        EXPECT_EQ(fine.points[7], V3f(0.5f, 0.5f, 0.5f));
    }
    EXPECT_EQ(before, -1);
}

/// A square of 4 by 4 faces, each in a region of a face-varying primvar that is cut along the
/// regions' borders, and, with `slit`, from (2, 2) to (2, 4).
struct Regions {
    Mesh cage = grid(4, 1);
    std::vector<float> values;          ///< three by value, random
    std::vector<std::int32_t> indices;  ///< by corner
    std::vector<std::set<std::int32_t>> values_at{25};
    std::map<std::int32_t, int> faces_of;  ///< by value

    explicit Regions(const std::function<int(int, int)>& region, bool slit = false) {
        std::map<std::array<int, 3>, std::int32_t> known;
        std::uint32_t random = 1;
        for (int corner = 0; corner < 64; ++corner) {
            const int face = corner / 4, x = face % 4;
            const int vertex = cage.face_vertex_indices[static_cast<std::size_t>(corner)];
            const bool east = slit && vertex % 5 == 2 && vertex / 5 > 2 && x >= 2;
            const std::array<int, 3> key{region(x, face / 4), vertex, east ? 1 : 0};
            const auto [at, added] =
                known.try_emplace(key, static_cast<std::int32_t>(known.size()));
            for (int i = 0; added && i < 3; ++i) {
                random = random * 1664525u + 1013904223u;
                values.push_back(static_cast<float>(random >> 16) / 65536);
            }
            indices.push_back(at->second);
            values_at[static_cast<std::size_t>(vertex)].insert(at->second);
            ++faces_of[at->second];
        }
    }
};

/// A face-varying primvar is refined as the points of a mesh would be that is cut where its values
/// are, each rule sharpening what UsdGeomMesh says it does. (The mesh's own corners are sharp by
/// interpolateBoundary.)
TEST(Subdivide, FaceVaryingRulesAreThoseOfAMeshCutAlongTheSeams) {
    using Rule = FaceVaryingRule;
    const Regions layouts[] = {
        Regions([](int x, int y) { return x < 2   ? 0
                                          : y < 2 ? 1
                                                  : 2; }),  // three meet
        Regions([](int x, int y) { return x >= 2 && y >= 2 ? 1 : 0; }),   // concave
        Regions([](int, int) { return 0; }, true),                        // a dart
        Regions([](int x, int y) { return x + 4 * y; }),                  // every face
        Regions([](int x, int y) { return (x > 0 && x < 3 && y < 2) ? 1 : 0; })};
    for (const Regions& layout : layouts) {
        std::vector<Mesh> refined;
        for (const Rule rule : {Rule::None, Rule::CornersOnly, Rule::CornersPlus1,
                                Rule::CornersPlus2, Rule::Boundaries, Rule::All}) {
            Mesh cage = layout.cage;
            cage.primvars = {{"v", Interpolation::FaceVarying, 3, layout.values, layout.indices}};
            Subdivision rules = level(3);
            rules.face_varying = rule;
            const Mesh fine = subdivide(cage, rules);
            const Primvar& got = fine.primvars[0];

            Mesh cut = layout.cage;
            cut.points.clear();
            for (std::size_t i = 0; i < layout.values.size(); i += 3)
                cut.points.emplace_back(layout.values[i], layout.values[i + 1],
                                        layout.values[i + 2]);
            cut.face_vertex_indices = layout.indices;
            Subdivision same_rules = level(3);
            same_rules.boundary =
                rule == Rule::None ? BoundaryRule::EdgeOnly : BoundaryRule::EdgeAndCorner;
            const auto sharpen = [&](std::int32_t value) {
                same_rules.corner_indices.push_back(value);
                same_rules.corner_sharpnesses.push_back(10);
            };
            for (std::size_t v = 0; v < layout.values_at.size(); ++v) {
                const std::set<std::int32_t>& there = layout.values_at[v];
                const bool junction = there.size() > 2, inside = v % 5 % 4 && v / 5 % 4;
                bool corner = false;
                for (const std::int32_t value : there)
                    corner = corner || layout.faces_of.at(value) == 1;
                const bool dart = &layout == &layouts[2] && v == 12;
                const bool mesh_corner = v == 0 || v == 4 || v == 20 || v == 24;
                if ((rule == Rule::None && mesh_corner) ||
                    (rule == Rule::CornersPlus1 && junction) ||
                    (rule == Rule::CornersPlus2 &&
                     (junction || dart || (inside && there.size() == 2 && corner))) ||
                    rule == Rule::Boundaries)
                    for (const std::int32_t value : there)
                        if (rule != Rule::Boundaries || !inside || there.size() > 1 || dart)
                            sharpen(value);
            }
            if (rule == Rule::Boundaries) {
                std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
                for (std::size_t i = 0; i < 64; ++i) {
                    const std::int32_t a = layout.indices[i],
                                       b = layout.indices[i % 4 == 3 ? i - 3 : i + 1];
                    ++edges[{std::min(a, b), std::max(a, b)}];
                }
                for (const auto& [edge, faces] : edges) {
                    if (faces == 2) continue;
                    same_rules.crease_indices.insert(same_rules.crease_indices.end(),
                                                     {edge.first, edge.second});
                    same_rules.crease_lengths.push_back(2);
                    same_rules.crease_sharpnesses.push_back(10);
                }
            }
            if (rule == Rule::All) same_rules.scheme = SubdivisionScheme::Bilinear;
            const Mesh expected = subdivide(cut, same_rules);
            ASSERT_EQ(got.indices.size(), expected.face_vertex_indices.size());
            double most = 0;
            for (std::size_t i = 0; i < got.indices.size(); ++i) {
                const auto at = 3 * static_cast<std::size_t>(got.indices[i]);
                const V3f& p =
                    expected.points[static_cast<std::size_t>(expected.face_vertex_indices[i])];
                for (int k = 0; k < 3; ++k)
                    most =
                        std::max(most, std::fabs(double(got.values[at + std::size_t(k)] - p[k])));
            }
            EXPECT_LT(most, 1e-5) << "layout " << &layout - layouts << ", rule "
                                  << static_cast<int>(rule);
            refined.push_back(fine);
        }
        EXPECT_FALSE(same(refined[0], refined[5]));
        EXPECT_EQ(same(refined[1], refined[4]), &layout == &layouts[3]);
    }
}

TEST(Subdivide, TheCageHasSmoothNormals) {
    const Mesh cage = subdivide(cube(), level(0));
    EXPECT_EQ(cage.points.size(), 8u);
    EXPECT_NEAR((cage.normals[0] - V3f(-1, -1, -1) / std::sqrt(3.f)).length(), 0, 1e-6);
}

}  // namespace
}  // namespace irt
