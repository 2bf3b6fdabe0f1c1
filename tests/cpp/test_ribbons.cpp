// SPDX-License-Identifier: Apache-2.0
// Ribbons against closed forms: where their edges are, that they close, what is refused.
#include "irt/scene/ribbons.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "irt/scene/compile.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

ControlCurves line(const std::vector<V3f>& points, CurveWrap wrap = CurveWrap::Nonperiodic) {
    ControlCurves curves;
    curves.wrap = wrap;
    curves.points = points;
    curves.vertex_counts = {static_cast<std::int32_t>(points.size())};
    curves.widths = {2};
    curves.normals = {{0, 0, 1}};
    curves.normals_interpolation = Interpolation::Constant;
    return curves;
}

double area_of(const Mesh& mesh) {
    const auto made = triangulate(std::make_shared<const Mesh>(mesh), M44d(), "/test");
    double area = 0;
    for (const auto& t : made->triangles) {
        const V3d a(made->points[t[0]]), b(made->points[t[1]]), c(made->points[t[2]]);
        area += (b - a).cross(c - a).length() / 2;
    }
    return area;
}

TEST(Ribbons, ALineIsARectangleThatFacesItsNormal) {
    const auto mesh = make_ribbons(line({{0, 0, 0}, {3, 0, 0}}), 8);
    ASSERT_EQ(mesh->face_vertex_counts, std::vector<std::int32_t>{4});
    EXPECT_EQ(mesh->points, (std::vector<V3f>{{0, 1, 0}, {0, -1, 0}, {3, 1, 0}, {3, -1, 0}}));
    EXPECT_EQ(mesh->normals, std::vector<V3f>(4, V3f(0, 0, 1)));
    const auto made = triangulate(mesh, M44d(), "/test");
    for (const auto& t : made->triangles) {
        const V3d a(made->points[t[0]]), b(made->points[t[1]]), c(made->points[t[2]]);
        EXPECT_GT((b - a).cross(c - a).z, 0);
    }
}

/// Where a flat ribbon bends it keeps its width, and its edges meet.
TEST(Ribbons, BendsKeepTheWidth) {
    const auto mesh = make_ribbons(line({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}}), 8);
    EXPECT_LT((mesh->points[2] - V3f(3, 1, 0)).length(), 1e-6f);
    EXPECT_LT((mesh->points[3] - V3f(5, -1, 0)).length(), 1e-6f);
    EXPECT_NEAR(area_of(*mesh), 2 * 8, 1e-5);
    // A hairpin reaches out no farther than twice half its width.
    const auto sharp = make_ribbons(line({{0, 0, 0}, {4, 0, 0}, {0, 0.1f, 0}}), 8);
    for (const V3f& p : sharp->points) EXPECT_LE(p.x, 6.001f);
}

TEST(Ribbons, RingsClose) {
    const auto mesh = make_ribbons(
        line({{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}}, CurveWrap::Periodic), 8);
    EXPECT_EQ(mesh->points.size(), 8u);
    EXPECT_EQ(mesh->face_vertex_counts.size(), 4u);
    // A frame: a square of side 4 with its middle, a square of side 0, covered.
    EXPECT_NEAR(area_of(*mesh), 16, 1e-5);
}

/// Four Bezier quarters of a circle in its plane, and standing on it: an annulus and a cylinder.
TEST(Ribbons, CirclesHaveTheirAreas) {
    const float k = 4.0f / 3 * (std::sqrt(2.0f) - 1);
    ControlCurves circle = line({{1, 0, 0},
                                 {1, k, 0},
                                 {k, 1, 0},
                                 {0, 1, 0},
                                 {-k, 1, 0},
                                 {-1, k, 0},
                                 {-1, 0, 0},
                                 {-1, -k, 0},
                                 {-k, -1, 0},
                                 {0, -1, 0},
                                 {k, -1, 0},
                                 {1, -k, 0}},
                                CurveWrap::Periodic);
    circle.basis = CurveBasis::Bezier;
    circle.widths = {0.5f};
    const double pi = std::numbers::pi;
    EXPECT_NEAR(area_of(*make_ribbons(circle, 64)), pi * (1.25 * 1.25 - 0.75 * 0.75), 2e-3);
    circle.normals = circle.points;
    circle.normals_interpolation = Interpolation::Vertex;
    EXPECT_NEAR(area_of(*make_ribbons(circle, 64)), 0.5 * 2 * pi, 2e-3);
}

/// The middle of every edge pair lies on the curve that tubes are made along, by every basis.
TEST(Ribbons, RunAlongTheCurvesThatTubesDo) {
    Random random(5);
    for (const CurveBasis basis :
         {CurveBasis::Linear, CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom})
        for (const CurveWrap wrap :
             {CurveWrap::Nonperiodic, CurveWrap::Periodic, CurveWrap::Pinned}) {
            std::vector<V3f> points;
            const int count = basis == CurveBasis::Bezier && wrap != CurveWrap::Periodic ? 7 : 6;
            for (int i = 0; i < count; ++i) points.emplace_back(V3f(random.point()));
            ControlCurves curves = line(points, wrap);
            curves.basis = basis;
            curves.widths_interpolation = Interpolation::Vertex;
            curves.widths.assign(points.size(), 0.25f);
            Primvar uniform{"a", Interpolation::Uniform, 1, {7}, {}};
            Primvar along{"b", Interpolation::FaceVarying, 1, {}, {}};
            for (std::size_t i = 0; i < element_count(curves, Interpolation::FaceVarying); ++i)
                along.values.push_back(static_cast<float>(i));
            curves.primvars = {uniform, along};
            const auto mesh = make_ribbons(curves, 5);
            const auto tubes = make_curves(curves, 5);
            ASSERT_EQ(mesh->points.size(), 2 * tubes->balls.size());
            for (std::size_t i = 0; i < tubes->balls.size(); ++i) {
                const V3f middle = (mesh->points[2 * i] + mesh->points[2 * i + 1]) * 0.5f;
                EXPECT_LT((middle - tubes->balls[i].centre).length(), 1e-6f);
                EXPECT_EQ(mesh->primvars[1].values[2 * i], tubes->primvars[1].values[i]);
            }
            EXPECT_EQ(mesh->primvars[0].indices.size(), mesh->face_vertex_counts.size());
            SceneBuilder builder;
            builder.add(mesh, M44d());
            EXPECT_NO_THROW(builder.scene());
        }
}

TEST(Ribbons, BadOnesAreRefused) {
    ControlCurves curves = line({{0, 0, 0}, {3, 0, 0}});
    curves.normals.push_back({0, 0, 1});
    EXPECT_THROW(make_ribbons(curves, 8), std::invalid_argument);
    // Normals along the curve, and points in one place, give strips of no area, but finite ones.
    const auto flat = make_ribbons(line({{0, 0, 0}, {0, 0, 3}, {0, 0, 3}}), 8);
    EXPECT_EQ(area_of(*flat), 0);
}

}  // namespace
}  // namespace irt
