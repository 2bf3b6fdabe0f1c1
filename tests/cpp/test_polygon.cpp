// SPDX-License-Identifier: Apache-2.0
// Polygons cut into triangles: nothing uncovered, nothing covered twice, whatever their shape.
#include "irt/scene/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trace_scenes.h"

namespace irt {
namespace {

using test::Random;
using Points = std::vector<V2d>;

double cross(const V2d& a, const V2d& b) { return a.x * b.y - a.y * b.x; }

double shoelace(const Points& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += cross(p[i], p[(i + 1) % p.size()]);
    return sum / 2;
}

/// Around a point, in and out at random: simple, with as many reflex corners as others.
Points star(Random& random, int count) {
    Points p;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count, r = std::exp2(2 * random());
        p.emplace_back(std::round(64 * r * std::cos(angle)), std::round(64 * r * std::sin(angle)));
    }
    return p;
}

/// Teeth on a bar, corners in line with each other.
Points comb(Random& random, int teeth) {
    Points p{{0, 0}, {2.0 * teeth, 0}};
    for (int i = teeth; i > 0; --i) {
        const double height = 2 + static_cast<double>(random.below(3));
        p.insert(p.end(), {{2.0 * i, height}, {2.0 * i - 1, height}, {2.0 * i - 1, 1}});
        p.emplace_back(2.0 * i - 2, 1);
    }
    return p;
}

Points spiral(int turns) {
    Points outward, inward;
    for (int i = 0; i <= 8 * turns; ++i) {
        const double angle = std::numbers::pi / 4 * i, r = 1 + 0.25 * i;
        outward.emplace_back(r * std::cos(angle), r * std::sin(angle));
        inward.emplace_back((r + 0.9) * std::cos(angle), (r + 0.9) * std::sin(angle));
    }
    outward.insert(outward.end(), inward.rbegin(), inward.rend());
    if (shoelace(outward) < 0) std::reverse(outward.begin(), outward.end());
    return outward;
}

/// A square with square holes, which bridges join to its boundary: edges and points lie on others.
Points keyhole(int holes) {
    Points p{{0, 0}};
    for (int i = 0; i < holes; ++i) {
        const double x = 4.0 * i + 1;
        p.insert(p.end(), {{x, 0}, {x, 1}, {x, 3}, {x + 2, 3}, {x + 2, 1}, {x, 1}, {x, 0}});
    }
    p.insert(p.end(), {{4.0 * holes, 0}, {4.0 * holes, 4}, {0, 4}});
    return p;
}

/// Two squares that touch at a corner, as one polygon.
Points hourglass() { return {{0, 0}, {2, 0}, {2, 2}, {4, 2}, {4, 4}, {2, 4}, {2, 2}, {0, 2}}; }

/// Points on edges, and points again.
Points refined(const Points& p, Random& random) {
    Points out;
    for (std::size_t i = 0; i < p.size(); ++i) {
        out.push_back(p[i]);
        if (random.below(3) == 0) out.push_back(p[i]);
        if (random.below(3) == 0) out.push_back((p[i] + p[(i + 1) % p.size()]) * 0.5);
    }
    return out;
}

/// In the plane z = x / 2 + y / 4, turned so that the axis `up` is z; clockwise if `reversed`.
Mesh face(Points p, int up, bool reversed) {
    if (reversed) std::reverse(p.begin(), p.end());
    Mesh mesh;
    mesh.face_vertex_counts = {static_cast<std::int32_t>(p.size())};
    for (std::size_t i = 0; i < p.size(); ++i) {
        V3f point;
        point[(up + 1) % 3] = static_cast<float>(p[i].x);
        point[(up + 2) % 3] = static_cast<float>(p[i].y);
        point[up] = static_cast<float>(p[i].x / 2 + p[i].y / 4);
        mesh.points.push_back(point);
        mesh.face_vertex_indices.push_back(static_cast<std::int32_t>(i));
    }
    return mesh;
}

/// The triangles' areas, seen from the front, are positive and sum to the polygon's.
void expect_covered(const Points& p, const char* what) {
    const double area = shoelace(p);
    ASSERT_GT(area, 0) << what;
    for (const int up : {0, 1, 2})
        for (const bool reversed : {false, true}) {
            const Mesh mesh = face(p, up, reversed);
            const auto count = static_cast<std::uint32_t>(p.size());
            const auto triangles = triangulate_polygon(mesh, 0, count);
            ASSERT_EQ(triangles.size(), p.size() - 2) << what;
            double sum = 0, least = 0;
            std::vector<int> used(p.size());
            for (const auto& triangle : triangles) {
                std::array<V2d, 3> at;
                for (std::size_t c = 0; c < 3; ++c) {
                    const V3f& point = mesh.points[triangle[c]];
                    at[c] = {double(point[(up + 1) % 3]), double(point[(up + 2) % 3])};
                    ++used[triangle[c]];
                }
                const double own = cross(at[1] - at[0], at[2] - at[0]) / 2 * (reversed ? -1 : 1);
                sum += std::fabs(own);
                least = std::min(least, own);
            }
            EXPECT_NEAR(sum, area, 1e-6 * area) << what;
            EXPECT_GE(least, -1e-7 * area) << what;
            EXPECT_GT(*std::min_element(used.begin(), used.end()), 0) << what;
        }
}

TEST(Polygon, TrianglesCoverItOnce) {
    Random random(1);
    for (int i = 0; i < 300; ++i) {
        const auto count = static_cast<int>(4 + random.below(40));
        const Points p = star(random, count);
        expect_covered(p, "star");
        expect_covered(refined(p, random), "refined star");
        expect_covered(refined(comb(random, 1 + i % 8), random), "comb");
    }
    for (int i = 1; i < 6; ++i) {
        expect_covered(spiral(i), "spiral");
        expect_covered(refined(spiral(i), random), "refined spiral");
        expect_covered(keyhole(i), "keyhole");
        expect_covered(refined(keyhole(i), random), "refined keyhole");
        expect_covered(refined(hourglass(), random), "hourglass");
    }
}

/// What has no inside, or crosses itself, is cut all the same: into as many triangles.
TEST(Polygon, NoPolygonIsLost) {
    Random random(2);
    for (const Points& p :
         {Points{{0, 0}, {1, 0}, {2, 0}, {1, 0}}, Points{{0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}},
          Points{{0, 0}, {2, 2}, {2, 0}, {0, 2}}, Points{{0, 0}, {1, 3}, {2, 0}, {0, 2}, {2, 2}}})
        EXPECT_EQ(
            triangulate_polygon(face(p, 2, false), 0, static_cast<std::uint32_t>(p.size())).size(),
            p.size() - 2);
    EXPECT_TRUE(triangulate_polygon(face({{0, 0}, {1, 0}}, 2, false), 0, 2).empty());
}

}  // namespace
}  // namespace irt
