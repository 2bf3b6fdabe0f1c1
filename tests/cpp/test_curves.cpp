// SPDX-License-Identifier: Apache-2.0
// Spheres and curves: round cones in closed form and at extremes, joints, and the polylines made of
// cubic curves.
#include <gtest/gtest.h>

#include "irt/scene/curves.h"
#include "irt/scene/equality.h"
#include "irt/scene/primvar.h"
#include "irt/trace/judge_many.h"
#include "irt/trace/round_cone.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

std::shared_ptr<Curves> chain(const std::vector<Ball>& balls, bool closed = false) {
    auto curves = std::make_shared<Curves>();
    curves->balls = balls;
    curves->curve_of.assign(balls.size(), 0);
    curves->firsts = {0, static_cast<std::uint32_t>(balls.size())};
    curves->closed = closed;
    return curves;
}

std::unique_ptr<Scene> scene_of(const Geometry& geometry, const M44d& m = M44d(),
                                const std::string& material = "opaque") {
    SceneBuilder builder;
    builder.add(geometry, m, material);
    return builder.scene();
}

/// Signed distance to the convex hull of two balls: the least over the balls between them, sought
/// by halving; nothing of the closed form is used.
double distance_to_hull(const Ball& a, const Ball& b, const V3d& p) {
    const auto at = [&](double u) {
        const V3d c = V3d(a.centre) * (1 - u) + V3d(b.centre) * u;
        return (p - c).length() - (double(a.radius) * (1 - u) + double(b.radius) * u);
    };
    double low = 0, high = 1;  // the function is convex in u
    for (int i = 0; i < 200; ++i) {
        const double x = low + (high - low) / 3, y = high - (high - low) / 3;
        (at(x) < at(y) ? high : low) = at(x) < at(y) ? y : x;
    }
    return std::min({at(low), at(0), at(1)});
}

TEST(RoundCone, HitsLieOnTheHullAndNothingIsMissed) {
    Random random(3);
    int hits = 0, misses = 0, sides = 0;
    for (int i = 0; i < 20000; ++i) {
        const double scale = std::exp2(std::round(30 * random()));
        Ball a{V3f(random.point() * scale), static_cast<float>(scale * (1 + random()) / 3)};
        Ball b{V3f(random.point() * scale), static_cast<float>(scale * (1 + random()) / 3)};
        if (i % 5 == 0) b.radius = a.radius;
        if (i % 5 == 1) b.radius = 0;
        if (i % 5 == 2) a.radius *= 1e-6f, b.radius *= 1e-6f;
        if (i % 5 == 3) {  // nearly one within the other, on either side of it
            const double length = (V3d(b.centre) - V3d(a.centre)).length();
            b.radius = static_cast<float>(double(a.radius) + length * (1 + 1e-6 * random()));
        }
        const V3d o = random.point() * scale * 4;
        const double u = 0.5 + 0.5 * random(), w = 1.05 + random();
        const V3d middle = V3d(a.centre) * (1 - u) + V3d(b.centre) * u;
        const double radius = double(a.radius) * (1 - u) + double(b.radius) * u;
        const V3d d = middle + random.direction() * radius * w - o;
        const trace::Interval in =
            trace::inside_round_cone({o, d}, trace::ExactBall(a), trace::ExactBall(b));
        const double tolerance = 1e-13 * scale * 8;
        if (in.empty()) {
            // The line's least distance, by halving: convex along the line.
            double low = -4, high = 4;
            for (int k = 0; k < 200; ++k) {
                const double x = low + (high - low) / 3, y = high - (high - low) / 3;
                const bool left =
                    distance_to_hull(a, b, o + d * x) < distance_to_hull(a, b, o + d * y);
                (left ? high : low) = left ? y : x;
            }
            ASSERT_GT(distance_to_hull(a, b, o + d * low), -tolerance) << i;
            ++misses;
            if (misses > 400) i += 7;
            continue;
        }
        ++hits;
        for (const auto& [t, piece] :
             {std::pair{in.enter, in.enter_piece}, {in.exit, in.exit_piece}}) {
            const V3d p = o + d * t;
            const trace::ShapePoint on =
                trace::on_round_cone(trace::ExactBall(a), trace::ExactBall(b), piece, p);
            // Where the ray grazes, the root of a rounding error separates line and surface.
            ASSERT_LT(std::fabs(distance_to_hull(a, b, p)), tolerance) << i;
            ASSERT_LT(std::fabs(distance_to_hull(a, b, on.position)), tolerance) << i;
            ASSERT_NEAR(on.normal.length(), 1, 1e-9) << i;
            ASSERT_GT(distance_to_hull(a, b, on.position + on.normal * (1e-3 * scale)),
                      0.99e-3 * scale)
                << i;
            sides += piece == 0;
        }
    }
    EXPECT_GT(hits, 4000);
    EXPECT_GT(misses, 400);
    EXPECT_GT(sides, 2000);
}

TEST(RoundCone, SilhouettesHaveTheirArea) {
    // Seen along z from far away, the hull of two discs of radii R and r at distance L.
    const double R = 0.5, r = 0.25, L = 1;
    const auto scene = scene_of(
        std::shared_ptr<const Curves>(chain({{{-0.5f, 0, 0}, 0.5f}, {{0.5f, 0, 0}, 0.25f}})));
    const int n = 400;
    int inside = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            inside += static_cast<bool>(brute_force_nearest(
                *scene, ray({(i + 0.5) * 3 / n - 1.5, (j + 0.5) * 3 / n - 1.5, 5}, {0, 0, -1})));
    const double beta = std::asin((R - r) / L), pi = 3.14159265358979323846;
    const double area =
        R * R * (pi / 2 + beta) + r * r * (pi / 2 - beta) + (R + r) * L * std::cos(beta);
    EXPECT_NEAR(inside * 9.0 / (n * n), area, 0.003);
}

/// A ray meets one surface where it enters a chain and one where it leaves it, whatever joints lie
/// between; a shadow ray is tinted once.
TEST(Curves, JointsAreInside) {
    const auto straight = chain({{{0, 0, 0}, 0.25f},
                                 {{1, 0, 0}, 0.25f},
                                 {{2, 0, 0}, 0.25f},
                                 {{2.125f, 0, 0}, 0.375f},
                                 {{3, 0, 0}, 0.125f}});
    const auto scene = scene_of(std::shared_ptr<const Curves>(straight), M44d(), "red glass");
    const auto trees = intersector(*scene);
    const trace::OpticalDepth once =
        scene->materials()[scene->all_objects()[0].surface.material].shadow_depth;
    trace::QueryCounts counts;
    for (const trace::Ray& r : {ray({-4, 0.01, 0.02}, {1, 0, 0}), ray({1, 4, 0}, {0, -1, 0}),
                                ray({4, 1, 0}, {-1, -0.4, 0}), ray({1.5, 0, 0}, {1, 0.01, 0})})
        EXPECT_EQ(trees->occlusion(r, counts).depth, once);
    const trace::Hit along = trees->nearest(ray({1, 0, 0}, {1, 0, 0}), counts);
    EXPECT_NEAR(along.t, 2.125, 1e-12);  // out of the far end, not into the next segment
    EXPECT_EQ(along.primitive, 3u);
    const trace::Hit joint = trees->nearest(ray({1, 4, 0}, {0, -1, 0}), counts);
    EXPECT_NEAR(joint.t, 3.75, 1e-12);
    EXPECT_EQ(joint.primitive, 0u);  // of two alike the lower
}

TEST(Curves, RingsCloseAndCrossingsCountEachTime) {
    const auto ring = chain(
        {{{1, 0, 0}, 0.25f}, {{0, 1, 0}, 0.25f}, {{-1, 0, 0}, 0.25f}, {{0, -1, 0}, 0.25f}}, true);
    const auto scene = scene_of(std::shared_ptr<const Curves>(ring), M44d(), "red glass");
    const auto trees = intersector(*scene);
    trace::QueryCounts counts;
    const trace::OpticalDepth once =
        scene->materials()[scene->all_objects()[0].surface.material].shadow_depth;
    trace::OpticalDepth twice = once;
    for (int c = 0; c < 3; ++c) twice.rgb[c] = std::min(2 * once.rgb[c], trace::depth_opaque);
    EXPECT_EQ(trees->nearest(ray({0.5, -0.5, 4}, {0, 0, -1}), counts).primitive, 3u);
    EXPECT_EQ(trees->occlusion(ray({-4, 0.001, 0}, {1, 0, 0}), counts).depth, twice);
    EXPECT_EQ(trees->occlusion(ray({1, 0, 4}, {0, 0, -1}), counts).depth, once);
    EXPECT_FALSE(trees->nearest(ray({0, 0, 4}, {0, 0, -1}), counts));
}

/// From inside a chain no ray gets out unseen, and what it sees it sees from behind.
TEST(Curves, NothingLeaks) {
    Random random(5);
    for (int i = 0; i < 300; ++i) {
        const auto curves = strands(random, 1, 6, i % 2 == 0, i % 3 == 0 ? 1e-3 : 0.2);
        const auto scene = scene_of(std::shared_ptr<const Curves>(curves));
        for (int k = 0; k < 100; ++k) {
            const Ball& ball = curves->balls[random.below(6)];
            if (!(ball.radius > 0)) continue;
            const V3d inside =
                V3d(V3f(V3d(ball.centre) + random.direction() * (0.9 * double(ball.radius))));
            const trace::Ray out = ray(inside, random.direction());
            const trace::Hit hit = brute_force_nearest(*scene, out);
            ASSERT_TRUE(hit) << i;
            const V3d from = V3d(V3f(inside + random.direction() * 3));
            const trace::Hit seen = brute_force_nearest(*scene, ray(from, inside - from));
            ASSERT_TRUE(seen && seen.t < 1) << i;
        }
    }
}

TEST(Spheres, ManyAreSeenAsSingleOnesAre) {
    Random random(9);
    const auto spheres = cloud(random, 30);
    const M44d m = random.transform(1);
    const auto together = scene_of(std::shared_ptr<const Spheres>(spheres), m);
    SceneBuilder builder;
    for (const Ball& ball : spheres->balls) {
        Quadric q;
        q.radius = static_cast<double>(ball.radius);
        if (ball.radius > 0) builder.add(q, translation(V3d(ball.centre)) * m);
    }
    const auto apart = builder.scene();
    int hits = 0;
    for (int i = 0; i < 5000; ++i) {
        const V3d from = random.point() * 6;
        const trace::Ray r = ray(from, random.point() - from);
        const trace::Hit a = brute_force_nearest(*together, r), b = brute_force_nearest(*apart, r);
        ASSERT_EQ(static_cast<bool>(a), static_cast<bool>(b));
        if (!a) continue;
        ++hits;
        EXPECT_NEAR(a.t, b.t, 1e-7);  // a grazed ball's t is the root of a rounding error
        EXPECT_LT((surface_point(*together, r, a).geometric_normal -
                   surface_point(*apart, r, b).geometric_normal)
                      .length(),
                  1e-6);
    }
    EXPECT_GT(hits, 200);
}

ControlCurves control(CurveBasis basis, CurveWrap wrap, const std::vector<V3f>& points) {
    ControlCurves c;
    c.basis = basis;
    c.wrap = wrap;
    c.points = points;
    c.vertex_counts = {static_cast<std::int32_t>(points.size())};
    c.widths = {0.5f};
    return c;
}

const std::vector<V3f> zigzag{{0, 0, 0}, {1, 2, 0}, {3, 2, 1}, {4, 0, 1},
                              {5, 1, 2}, {6, 3, 0}, {8, 0, 0}};

TEST(MakeCurves, CubicsPassWhereTheirBasesSay) {
    const auto at = [](const Curves& c, std::size_t i) { return V3d(c.balls[i].centre); };
    const auto near = [](const V3d& a, const V3d& b) { return (a - b).length() < 1e-6; };
    const auto bezier = make_curves(control(CurveBasis::Bezier, CurveWrap::Nonperiodic, zigzag), 4);
    ASSERT_EQ(bezier->balls.size(), 9u);
    EXPECT_TRUE(near(at(*bezier, 0), V3d(zigzag[0])));
    EXPECT_TRUE(near(at(*bezier, 4), V3d(zigzag[3])));
    EXPECT_TRUE(near(at(*bezier, 8), V3d(zigzag[6])));
    EXPECT_TRUE(near(
        at(*bezier, 2),
        (V3d(zigzag[0]) + V3d(zigzag[1]) * 3.0 + V3d(zigzag[2]) * 3.0 + V3d(zigzag[3])) / 8.0));
    const auto rom =
        make_curves(control(CurveBasis::CatmullRom, CurveWrap::Nonperiodic, zigzag), 4);
    ASSERT_EQ(rom->balls.size(), 17u);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(near(at(*rom, 4 * i), V3d(zigzag[i + 1])));
    const auto spline =
        make_curves(control(CurveBasis::BSpline, CurveWrap::Nonperiodic, zigzag), 4);
    EXPECT_TRUE(
        near(at(*spline, 0), (V3d(zigzag[0]) + V3d(zigzag[1]) * 4.0 + V3d(zigzag[2])) / 6.0));
    EXPECT_TRUE(
        near(at(*spline, 16), (V3d(zigzag[4]) + V3d(zigzag[5]) * 4.0 + V3d(zigzag[6])) / 6.0));
    for (const CurveBasis basis : {CurveBasis::BSpline, CurveBasis::CatmullRom}) {
        const auto pinned = make_curves(control(basis, CurveWrap::Pinned, zigzag), 4);
        ASSERT_EQ(pinned->balls.size(), 25u);
        EXPECT_TRUE(near(at(*pinned, 0), V3d(zigzag.front())));
        EXPECT_TRUE(near(at(*pinned, 24), V3d(zigzag.back())));
        const auto closed = make_curves(control(basis, CurveWrap::Periodic, zigzag), 4);
        EXPECT_EQ(closed->balls.size(), 28u);
        EXPECT_TRUE(closed->closed);
    }
    const auto line = make_curves(control(CurveBasis::Linear, CurveWrap::Pinned, zigzag), 4);
    EXPECT_EQ(line->balls.size(), 7u);
}

/// The stated bound on how far the chain is from the curve, which a finer chain stands for.
TEST(MakeCurves, ChordsKeepTheirBound) {
    for (const CurveBasis basis :
         {CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom}) {
        const ControlCurves c = control(basis, CurveWrap::Nonperiodic, zigzag);
        const auto fine = make_curves(c, 1024);
        const auto second = [&](std::size_t i) {  // P'' by central differences
            const auto p = [&](std::size_t k) { return V3d(fine->balls[k].centre); };
            return (p(i - 64) - p(i) * 2.0 + p(i + 64)).length() * 256;
        };
        for (const int n : {2, 8}) {
            const auto coarse = make_curves(c, n);
            const std::size_t step = static_cast<std::size_t>(1024 / n);
            double worst = 0, most = 0;
            for (std::size_t i = 0; i + 1 < fine->balls.size(); ++i) {
                const double u = static_cast<double>(i % step) / static_cast<double>(step);
                const V3d chord = V3d(coarse->balls[i / step].centre) * (1 - u) +
                                  V3d(coarse->balls[i / step + 1].centre) * u;
                worst = std::max(worst, (V3d(fine->balls[i].centre) - chord).length());
                if (i % 1024 >= 64 && i % 1024 <= 960) most = std::max(most, second(i));
            }
            EXPECT_LT(worst, most * 1.2 / (8 * n * n) + 1e-6);
            EXPECT_GT(worst, 0);
        }
    }
}

TEST(MakeCurves, WidthsFollowTheirInterpolation) {
    ControlCurves c = control(CurveBasis::Bezier, CurveWrap::Nonperiodic, zigzag);
    const auto radius = [&](std::size_t ball) { return make_curves(c, 2)->balls[ball].radius; };
    c.widths = {1, 0, 2};
    c.widths_interpolation = Interpolation::FaceVarying;
    EXPECT_EQ(radius(0), 0.5f);
    EXPECT_EQ(radius(1), 0.25f);
    EXPECT_EQ(radius(3), 0.5f);
    EXPECT_EQ(radius(4), 1.0f);
    c.widths = {1, 1, 1, 2, 0, 0, 0};
    c.widths_interpolation = Interpolation::Vertex;
    EXPECT_EQ(radius(0), 0.5f);
    EXPECT_EQ(radius(1), (1 + 3 + 3 + 2) / 16.0f);
    EXPECT_EQ(radius(4), 0.0f);
    c.widths = {3};
    c.widths_interpolation = Interpolation::Uniform;
    EXPECT_EQ(radius(2), 1.5f);
    c.widths = {1, 2};
    EXPECT_THROW(make_curves(c, 2), std::invalid_argument);
    c.widths = {3};
    c.vertex_counts = {6};
    EXPECT_THROW(make_curves(c, 2), std::invalid_argument);
}

TEST(MakeCurves, PrimvarsFollowTheirCurve) {
    ControlCurves c = control(CurveBasis::Bezier, CurveWrap::Nonperiodic, zigzag);
    c.primvars = {{"a", Interpolation::Constant, 1, {7}, {}},
                  {"b", Interpolation::Uniform, 2, {1, 2}, {}},
                  {"c", Interpolation::Vertex, 1, {0, 3, 3, 0, 0, 0, 6}, {}},
                  {"d", Interpolation::FaceVarying, 1, {0, 1}, {0, 1, 0}}};
    const auto curves = make_curves(c, 2);
    const auto at = [&](const char* name, std::uint32_t segment, double u) {
        return primvar_at(*curves, *find_primvar(curves->primvars, name), segment, u)[0];
    };
    EXPECT_EQ(at("a", 3, 0.5), 7);
    EXPECT_EQ(at("b", 3, 0.5), 1);
    EXPECT_EQ(at("c", 0, 0), 0);
    EXPECT_EQ(at("c", 0, 1), 2.25);  // of 0 3 3 0 at the middle of its span
    EXPECT_EQ(at("c", 0, 0.5), 1.125);
    EXPECT_EQ(at("c", 3, 1), 6);
    EXPECT_EQ(at("d", 1, 1), 1);
    EXPECT_EQ(at("d", 2, 0.5), 0.75);
    // The hit says how far along its segment it is.
    SceneBuilder builder;
    builder.add(std::shared_ptr<const Curves>(chain({{{0, 0, 0}, 0.25f}, {{2, 0, 0}, 0.25f}})),
                M44d());
    const auto scene = builder.scene();
    EXPECT_NEAR(brute_force_nearest(*scene, ray({1.5, 4, 0}, {0, -1, 0})).u, 0.75, 1e-12);
    c.primvars[2].values.pop_back();
    EXPECT_THROW(make_curves(c, 2), std::invalid_argument);
}

TEST(Spheres, OnePointMovedIsAChangeAndNothingElseIs) {
    Random random(4);
    const auto spheres = cloud(random, 100);
    auto other = std::make_shared<Spheres>(*spheres);
    EXPECT_TRUE(same(Geometry(std::shared_ptr<const Spheres>(spheres)),
                     Geometry(std::shared_ptr<const Spheres>(other))));
    other->balls[57].centre.z = std::nextafter(other->balls[57].centre.z, 2.0f);
    EXPECT_FALSE(same(Geometry(std::shared_ptr<const Spheres>(spheres)),
                      Geometry(std::shared_ptr<const Spheres>(other))));
}

TEST(Spheres, BadOnesAreRefused) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Ball& ball : {Ball{{0, 0, 0}, -1}, Ball{{nan, 0, 0}, 1}, Ball{{0, 0, 0}, nan},
                             Ball{{3e38f, 0, 0}, 1}}) {
        auto spheres = std::make_shared<Spheres>();
        spheres->balls = {ball};
        EXPECT_THROW(scene_of(std::shared_ptr<const Spheres>(spheres)), std::invalid_argument);
        EXPECT_THROW(scene_of(std::shared_ptr<const Curves>(chain({ball, ball}))),
                     std::invalid_argument);
    }
}

}  // namespace
}  // namespace irt
