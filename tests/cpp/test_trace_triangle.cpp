// SPDX-License-Identifier: Apache-2.0
// The triangle judge: four lanes as one, closed meshes, slivers, edges that belong to one triangle.
#include <gtest/gtest.h>

#include "irt/trace/judge_triangle.h"
#include "irt/trace/packets.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

/// Eight triangles, in pairs, from a small grid (many exact zeros) or at random.
TEST(JudgePacket, EachTriangleHasTheBitsOfTheScalarJudge) {
    Random random(1);
    int inside = 0, alone = 0;
    for (int i = 0; i < 100000; ++i) {
        const bool grid = i % 2 == 0;
        const auto point = [&] {
            V3d p = random.point() * 2;
            return grid ? V3f(V3d(std::round(p.x), std::round(p.y), std::round(p.z))) : V3f(p);
        };
        Triangles mesh;
        for (std::uint32_t k = 0; k < 16; ++k) mesh.points.push_back(point());
        for (std::uint32_t k = 0; k < 16; k += 4) {
            std::array<std::uint32_t, 3> a{k, k + 1, k + 2}, b{k, k + 2, k + 3};
            std::rotate(a.begin(), a.begin() + random.below(3), a.end());
            std::rotate(b.begin(), b.begin() + random.below(3), b.end());
            mesh.triangles.push_back(a);
            mesh.triangles.push_back(b);
        }
        const auto packets = trace::make_packets(mesh, trace::cluster(mesh));
        ASSERT_EQ(packets.size(), 1u);
        const V3f from = point();
        const trace::JudgeRay ray = judge_ray(trace::make_ray(from, point() - from));
        trace::PacketHits eight;
        judge_packet(packets[0], ray, eight);
        alone += eight.alone != 0 ? 1 : 0;
        for (int side = 0; side < 2; ++side)
            for (int lane = 0; lane < 4; ++lane) {
                const auto& v = mesh.triangles[packets[0].triangle(side, lane)];
                trace::TriangleHit hit, twin;
                const bool met = judge_triangle(mesh.points[v[0]], mesh.points[v[1]],
                                                mesh.points[v[2]], ray, twin);
                const bool maybe = ((eight.inside | eight.alone) >> (4 * side + lane) & 1) != 0;
                ASSERT_EQ(met, maybe && finish_lane(packets[0], ray, eight, side, lane, hit)) << i;
                if (!met) continue;
                ++inside;
                ASSERT_TRUE(same_bits(hit.t, twin.t)) << i;
                ASSERT_TRUE(same_bits(hit.u, twin.u)) << i;
                ASSERT_TRUE(same_bits(hit.v, twin.v)) << i;
                ASSERT_EQ(hit.front, twin.front) << i;
            }
    }
    EXPECT_GT(inside, 10000);
    EXPECT_GT(alone, 1000);
}

TEST(JudgePacket, AbsentTrianglesAreNeverMet) {
    Triangles triangles;
    triangles.points = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    triangles.triangles = {{0, 1, 2}};
    const auto packets = trace::make_packets(triangles, trace::cluster(triangles));
    ASSERT_EQ(packets.size(), 1u);
    trace::PacketHits hits;
    trace::TriangleHit hit;
    for (const double side : {1.0, -1.0}) {
        const trace::JudgeRay r = judge_ray(ray({0, 0, side}, {0, 0, -side}));
        judge_packet(packets[0], r, hits);
        ASSERT_EQ(hits.inside | hits.alone, 1u);
        ASSERT_TRUE(finish_lane(packets[0], r, hits, 0, 0, hit));
        EXPECT_EQ(hit.t, 1);
        EXPECT_EQ(hit.front, side > 0);
    }
}

/// The line through a vertex or an edge of a flat grid belongs to exactly one triangle.
TEST(JudgeTriangle, SharedEdgesAndVerticesBelongToOneTriangle) {
    const auto grid = board(4, 0.5);
    Random random(3);
    for (int i = 0; i < 20000; ++i) {
        const auto corner = [&] { return V3d(grid->points[random.below(grid->points.size())]); };
        const V3d a = corner(), b = corner();
        V3d target = i % 2 == 0 ? a : (a + b) * 0.5;
        if (std::max(std::fabs(target.x), std::fabs(target.y)) >= 1) continue;
        const V3d from =
            i % 3 == 0 ? target + V3d(0, 0, 4) : V3d(V3f(random.point() + V3d(0, 0, 2)));
        const trace::JudgeRay r = judge_ray(ray(from, target - from));
        int met = 0;
        for (std::size_t k = 0; k < grid->face_vertex_indices.size(); k += 3) {
            const auto vertex = [&](std::size_t c) {
                return grid->points[static_cast<std::size_t>(grid->face_vertex_indices[k + c])];
            };
            trace::TriangleHit hit;
            met += judge_triangle(vertex(0), vertex(1), vertex(2), r, hit) ? 1 : 0;
        }
        ASSERT_EQ(met, 1) << i;
    }
}

/// A line through a closed mesh crosses it as often inwards as outwards.
TEST(JudgeTriangle, LinesCrossClosedMeshesEvenly) {
    const std::shared_ptr<const Mesh> closed[] = {ball(12, 16), pawn(12, 16), box()};
    Random random(4);
    for (const auto& mesh : closed) {
        SceneBuilder builder;
        builder.add(mesh, rotation(0, 0.1));
        const auto scene = builder.scene();
        const Triangles& t = *scene->all_objects()[0].surface.triangles;
        for (int i = 0; i < 3000; ++i) {
            const auto vertex = [&] { return V3d(t.points[random.below(t.points.size())]); };
            const V3d from = i % 5 == 0 ? vertex() : random.point() * 3;
            const V3d target = i % 2 == 0 ? vertex() : (vertex() + vertex()) * 0.5;
            if (from == target) continue;
            const trace::JudgeRay r = judge_ray(ray(from, target - from));
            int winding = 0;
            for (const auto& v : t.triangles) {
                trace::TriangleHit hit;
                if (judge_triangle(t.points[v[0]], t.points[v[1]], t.points[v[2]], r, hit))
                    winding += hit.front ? 1 : -1;
            }
            ASSERT_EQ(winding, 0) << i;
        }
    }
}

/// A fan of needles 1 long and 1e-7 wide: no ray aimed at the disc of it is lost.
TEST(JudgeTriangle, SliversDoNotLeak) {
    auto mesh = std::make_shared<Mesh>();
    const int needles = 2000;
    for (int i = 0; i <= needles; ++i)
        for (const double side : {-1.0, 1.0})
            mesh->points.emplace_back(static_cast<float>(side),
                                      static_cast<float>(i * 1.2e-7 + 0.001),
                                      static_cast<float>(0.25 * side));
    for (int i = 0; i < needles; ++i) {
        add_triangle(*mesh, 2 * i, 2 * i + 1, 2 * i + 3);
        add_triangle(*mesh, 2 * i, 2 * i + 3, 2 * i + 2);
    }
    SceneBuilder builder;
    builder.add(std::shared_ptr<const Mesh>(mesh), M44d());
    const auto scene = builder.scene();
    const auto trees = intersector(*scene), low = intersector(*scene, {true, 1}, "sse2");
    trace::QueryCounts counts;
    Random random(5);
    for (int i = 0; i < 5000; ++i) {
        const double x = 0.9 * random(), width = needles * 1.2e-7;
        const V3d target(x, 0.001 + width * (0.5 + 0.45 * random()), 0.25 * x);
        const V3d from(0.3 * random(), 0.001 + width * (0.5 + 0.45 * random()), 2 + random());
        const trace::Ray r = ray(from, target - from);
        const trace::Hit hit = trees->nearest(r, counts);
        ASSERT_TRUE(hit) << i;
        ASSERT_TRUE(same(hit, low->nearest(r, counts)));
        if (i % 50 == 0) {
            ASSERT_TRUE(same(hit, brute_force_nearest(*scene, r)));
        }
    }
}

/// Pairs of triangles that follow each other, and of triangles that do not; every one once.
TEST(Clusters, PairTrianglesAndKeepEachOnce) {
    Random random(6);
    SceneBuilder builder;
    builder.add(std::shared_ptr<const Mesh>(pawn(20, 31)), M44d());
    const auto scene = builder.scene();
    Triangles triangles = *scene->all_objects()[0].surface.triangles;
    for (const bool shuffled : {false, true}) {
        if (shuffled)
            for (std::size_t i = triangles.triangles.size(); i > 1; --i)
                std::swap(triangles.triangles[i - 1], triangles.triangles[random.below(i)]);
        const auto order = trace::cluster(triangles);
        EXPECT_LT(order.size(), triangles.triangles.size() * 3 / 4);
        std::vector<int> seen(triangles.triangles.size(), 0);
        for (const trace::TrianglePacket& packet : trace::make_packets(triangles, order))
            for (int side = 0; side < 2; ++side)
                for (int lane = 0; lane < 4; ++lane) {
                    if (packet.primitive[side][lane] == trace::none) continue;
                    const std::uint32_t triangle = packet.triangle(side, lane);
                    ++seen[triangle];
                    for (int k = 0; k < 3; ++k) {
                        const int corner = (k + packet.turn(side, lane)) % 3;
                        ASSERT_EQ(
                            packet.point(trace::TrianglePacket::corner[side][corner], lane),
                            triangles.points[triangles.triangles[triangle]
                                                                [static_cast<std::size_t>(k)]]);
                    }
                }
        for (const int times : seen) ASSERT_EQ(times, 1);
    }
}

TEST(Meshes, SingleSidedOnesHaveNoBack) {
    auto mesh = std::make_shared<Mesh>(*board(2, 1));
    mesh->single_sided = true;
    auto mirrored = std::make_shared<Mesh>(*mesh);
    mirrored->left_handed = true;
    for (const bool left : {false, true})
        for (const double sign : {1.0, -1.0}) {
            SceneBuilder builder;
            builder.add(std::shared_ptr<const Mesh>(left ? mirrored : mesh), scaling({1, 1, sign}));
            const auto scene = builder.scene();
            const auto trees = intersector(*scene);
            trace::QueryCounts counts;
            const trace::Ray down = ray({0.3, 0.2, 1}, {0, 0, -1}),
                             up = ray({0.3, 0.2, -1}, {0, 0, 1});
            const trace::Hit hits[] = {trees->nearest(down, counts), trees->nearest(up, counts)};
            EXPECT_NE(static_cast<bool>(hits[0]), static_cast<bool>(hits[1]));
            const bool from_above = static_cast<bool>(hits[0]);
            const trace::SurfacePoint point =
                surface_point(*scene, from_above ? down : up, hits[from_above ? 0 : 1]);
            EXPECT_TRUE(point.front);
            EXPECT_EQ(point.geometric_normal.z, from_above ? 1 : -1);
            EXPECT_NE(trees->occlusion(down, counts).blocker == trace::none,
                      trees->occlusion(up, counts).blocker == trace::none);
        }
}

}  // namespace
}  // namespace irt
