// SPDX-License-Identifier: Apache-2.0
// Quadrics in closed form, the points and normals of every surface, and rays that leave them.
#include <gtest/gtest.h>

#include "irt/trace/judge_quadric.h"
#include "irt/trace/ray_origin.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

trace::Hit hit_of(const Quadric& q, const M44d& m, const trace::Ray& r) {
    SceneBuilder builder;
    builder.add(q, m);
    const auto scene = builder.scene();
    trace::QueryCounts counts;
    return intersector(*scene)->nearest(r, counts);
}

/// Within 1e-13: make_ray turns axis-parallel rays by 1e-15 (direction_nudge).
TEST(Quadrics, ClosedForms) {
    Quadric q;
    q.radius = 0.5;
    q.height = 3;
    const auto t = [&](QuadricKind kind, const V3d& o, const V3d& d) {
        q.kind = kind;
        const trace::Hit hit = hit_of(q, M44d(), ray(o, d));
        return hit ? hit.t : -1;
    };
    EXPECT_NEAR(t(QuadricKind::Sphere, {0, 0, 4}, {0, 0, -1}), 3.5, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Sphere, {0, 0, 0}, {0, 0, -1}), 0.5, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Sphere, {0.3125, 0, 4}, {0, 0, -2}),
                (4 - std::sqrt(0.25 - 0.3125 * 0.3125)) / 2, 1e-13);
    EXPECT_EQ(t(QuadricKind::Sphere, {0.51, 0, 4}, {0, 0, -1}), -1);
    EXPECT_EQ(t(QuadricKind::Sphere, {0, 0, 4}, {0, 0, 1}), -1);
    EXPECT_NEAR(t(QuadricKind::Cube, {0.25, 0.5, 4}, {0, 0, -1}), 3, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Cylinder, {0.25, 0.25, 4}, {0, 0, -1}), 2.5, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Cylinder, {4, 0, 1.25}, {-1, 0, 0}), 3.5, 1e-13);
    EXPECT_EQ(t(QuadricKind::Cylinder, {4, 0, 1.75}, {-1, 0, 0}), -1);
    EXPECT_NEAR(t(QuadricKind::Cone, {4, 0, 0}, {-1, 0, 0}), 3.75, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Cone, {0.25, 0, -4}, {0, 0, 1}), 2.5, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Cone, {0, 0, 4}, {0, 0, -1}), 2.5, 1e-13);
    EXPECT_EQ(t(QuadricKind::Cone, {4, 0, 1.75}, {-1, 0, 0}), -1);
    EXPECT_NEAR(t(QuadricKind::Capsule, {0, 0, 4}, {0, 0, -1}), 2, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Capsule, {4, 0, 0.5}, {-1, 0, 0}), 3.5, 1e-13);
    q.radius_top = 0.125;
    EXPECT_NEAR(t(QuadricKind::Frustum, {4, 0, 0}, {-1, 0, 0}), 4 - 0.3125, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Frustum, {0.0625, 0, 4}, {0, 0, -1}), 2.5, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Frustum, {0.3125, 0, 4}, {0, 0, -1}), 4, 1e-13);
    EXPECT_EQ(t(QuadricKind::Frustum, {0.3, 4, 1.4}, {0, -1, 0}), -1);
    EXPECT_NEAR(t(QuadricKind::RoundCone, {0, 0, 4}, {0, 0, -1}), 2.375, 1e-13);
    EXPECT_NEAR(t(QuadricKind::RoundCone, {0, 0, -4}, {0, 0, 1}), 2, 1e-13);
    // Of a round cone's middle the side's distance from the axis is the mean radius over cosine.
    EXPECT_NEAR(t(QuadricKind::RoundCone, {4, 0, 0}, {-1, 0, 0}),
                4 - 0.3125 / std::sqrt(1 - 0.125 * 0.125), 1e-13);
    q.radius = 4;  // holds the other ball
    EXPECT_NEAR(t(QuadricKind::RoundCone, {0, 0, 9}, {0, 0, -1}), 9 - 2.5, 1e-13);
    EXPECT_NEAR(t(QuadricKind::Plane, {0.75, -0.75, 4}, {0, 0, -1}), 4, 1e-13);
    EXPECT_EQ(t(QuadricKind::Plane, {1.25, 0, 4}, {0, 0, -1}), -1);
}

/// The implicit function that is zero on the surface of a piece, negative inside.
double implicit(const Quadric& q, std::uint8_t piece, const V3d& p) {
    const double h = q.height / 2, around = p.x * p.x + p.y * p.y;
    switch (q.kind) {
        case QuadricKind::Sphere:
            return p.dot(p) - q.radius * q.radius;
        case QuadricKind::Cube:
            return p[piece / 2] * (piece % 2 == 0 ? -1 : 1) - q.size / 2;
        case QuadricKind::Cylinder:
            return piece == 0 ? around - q.radius * q.radius : (piece == 1 ? -p.z : p.z) - h;
        case QuadricKind::Cone: {
            const double w = (h - p.z) * q.radius / q.height;
            return piece == 0 ? around - w * w : -p.z - h;
        }
        case QuadricKind::Capsule: {
            const double z = piece == 0 ? 0 : p.z - (piece == 1 ? -h : h);
            return around + z * z - q.radius * q.radius;
        }
        case QuadricKind::Frustum: {
            const double middle = (q.radius + q.radius_top) / 2,
                         w = middle + (q.radius_top - q.radius) * p.z / q.height;
            return piece == 0 ? around - w * w : (piece == 1 ? -p.z : p.z) - h;
        }
        case QuadricKind::RoundCone: {
            if (piece != 0) {
                const double r = piece == 1 ? q.radius : q.radius_top,
                             z = p.z - (piece == 1 ? -h : h);
                return around + z * z - r * r;
            }
            const double sine = (q.radius - q.radius_top) / q.height,
                         w = (q.radius + q.radius_top) / 2 - sine * p.z;
            return around * (1 - sine * sine) - w * w;
        }
        case QuadricKind::Plane:
            return p.z;
    }
    return 1;
}

TEST(Quadrics, HitsLieOnTheirPieceAndNormalsAreGradients) {
    Random random(1);
    for (const auto& [kind, name] : quadric_kinds()) {
        int hits = 0;
        for (int i = 0; i < 3000; ++i) {
            Quadric q = quadric(kind);
            q.radius = std::exp2(random());
            q.radius_top = std::exp2(2 * random()) - 0.25;
            q.height = std::exp2(random());
            const M44d m = random.transform(2);
            SceneBuilder builder;
            builder.add(q, m);
            const auto scene = builder.scene();
            const Surface& surface = scene->all_objects()[0].surface;
            const V3d from = random.point() * 6, to = random.point() * 2;
            const trace::Ray r = ray(from, to - from);
            const trace::Hit hit = brute_force_nearest(*scene, r);
            if (!hit) continue;
            ++hits;
            const trace::SurfacePoint point = surface_point(*scene, r, hit);
            const V3d on_ray = V3d(r.origin) + V3d(r.direction) * hit.t;
            EXPECT_LT((point.position - on_ray).length(), 1e-12) << name;
            const auto f = [&](const V3d& p) {
                return implicit(q, hit.piece, transform_point(surface.shape_from_trace, p));
            };
            EXPECT_LT(std::fabs(f(point.position)), 1e-13) << name;
            EXPECT_GT(point.error, 0);
            EXPECT_LT(point.error, 1e-12);
            V3d gradient;
            for (int a = 0; a < 3; ++a) {
                V3d step(0, 0, 0);
                step[a] = 1e-5;
                gradient[a] = f(point.position + step) - f(point.position - step);
            }
            if (gradient.length() < 1e-8) continue;  // the apex of a cone has none
            gradient.normalize();
            EXPECT_NEAR(gradient.dot(point.geometric_normal), 1, 1e-6) << name;
            EXPECT_EQ(point.front, V3d(r.direction).dot(gradient) < 0) << name;
        }
        EXPECT_GT(hits, 100) << name;
    }
}

/// Every kind of surface, in objects and in instances, seen at several scales and distances from
/// the origin: a ray that leaves does not meet the primitive it leaves from the wrong side.
TEST(RayOrigin, LeavingRaysNeverMeetTheirPrimitiveFromTheWrongSide) {
    Random random(2);
    for (int i = 0; i < 6000; ++i) {
        const std::size_t kinds = quadric_kinds().size(), k = random.below(kinds + 2);
        Geometry geometry;
        bool convex = true;
        if (k < kinds) {
            geometry = quadric(quadric_kinds()[k].first);
        } else {
            geometry = k == kinds ? std::shared_ptr<const Mesh>(box())
                                  : std::shared_ptr<const Mesh>(ball(6, 8));
            convex = false;  // judged triangle by triangle
        }
        const double scale = std::exp2(20 * random());
        const M44d m = random.transform(i % 3 == 0 ? 1e4 : 4) * scaling(V3d(scale));
        if (i % 2 == 0) {
            auto prototype = std::make_shared<Prototype>();
            prototype->parts.push_back({"p", geometry, random.transform(3), "opaque"});
            geometry = std::shared_ptr<const Prototype>(prototype);
        }
        SceneBuilder builder;
        builder.add(geometry, m);
        const auto scene = builder.scene();
        const ObjectSlot& object = scene->all_objects()[0];
        V3d centre = transform_point(object.part(0).trace_from_shape, {0, 0, 0});
        if (object.prototype) centre = transform_point(object.render_from_prototype, centre);
        for (int shot = 0; shot < 8; ++shot) {
            const V3d from = centre + random.point() * (shot % 2 == 0 ? 0.2 : 8) * scale;
            const trace::Ray r = ray(from, centre + random.point() * scale - from);
            const trace::Hit hit = brute_force_nearest(*scene, r);
            if (!hit) continue;
            const trace::SurfacePoint point = surface_point(*scene, r, hit);
            V3d d = random.direction();
            if (shot % 3 == 0)
                d -= point.geometric_normal * (0.999999 * d.dot(point.geometric_normal));
            d = V3d(V3f(d));
            const bool outwards = d.dot(point.geometric_normal) > 0;
            const trace::Ray leaving = ray(V3d(offset_ray_origin(point, d)), d);
            const trace::Hit again = brute_force_nearest(*scene, leaving);
            if (!again) continue;
            if (convex) {
                ASSERT_FALSE(outwards) << "object " << i << " kind " << k << " t " << again.t;
            } else {
                ASSERT_NE(again.primitive, hit.primitive) << "object " << i << " t " << again.t;
            }
        }
    }
}

TEST(SurfacePoint, ShadingNormalsFollowTheirInterpolation) {
    auto mesh = std::make_shared<Mesh>(*board(2, 1));
    const V3f tilted(0.6f, 0, 0.8f);
    const auto normal = [&](Interpolation interpolation, std::size_t count) {
        mesh->normals_interpolation = interpolation;
        mesh->normals.assign(count, tilted);
        SceneBuilder builder;
        builder.add(std::shared_ptr<const Mesh>(std::make_shared<Mesh>(*mesh)), scaling({2, 1, 1}));
        const auto scene = builder.scene();
        const trace::Ray r = ray({0.3, 0.2, 1}, {0, 0, -1});
        return surface_point(*scene, r, brute_force_nearest(*scene, r)).shading_normal;
    };
    const V3d expected = V3d(0.3, 0, 0.8).normalized();  // the inverse transpose shrinks x
    EXPECT_LT((normal(Interpolation::Constant, 1) - expected).length(), 1e-7);
    EXPECT_LT((normal(Interpolation::Uniform, 8) - expected).length(), 1e-7);
    EXPECT_LT((normal(Interpolation::Vertex, 9) - expected).length(), 1e-7);
    EXPECT_LT((normal(Interpolation::FaceVarying, 24) - expected).length(), 1e-7);
    EXPECT_LT((normal(Interpolation::None, 0) - V3d(0, 0, 1)).length(), 1e-15);
}

/// Tints multiply, in whatever order the tree finds them; opaque saturates.
TEST(Occlusion, TintsAddAsDepths) {
    SceneBuilder builder;
    for (int i = 0; i < 3; ++i) {
        Quadric q = quadric(QuadricKind::Plane);
        builder.add(q, translation({0, 0, 1.0 * i}), i == 1 ? "red glass" : "glass");
    }
    const auto scene = builder.scene();
    const auto trees = intersector(*scene);
    trace::QueryCounts counts;
    const trace::Occlusion all = trees->occlusion(ray({0.1, 0.2, -1}, {0, 0, 1}), counts);
    trace::OpticalDepth sum;
    for (std::uint32_t i = 0; i < 3; ++i) {
        const auto& depth =
            scene->materials()[scene->all_objects()[i].surface.material].shadow_depth;
        for (int c = 0; c < 3; ++c)
            sum.rgb[c] = std::min(sum.rgb[c] + depth.rgb[c], trace::depth_opaque);
    }
    EXPECT_EQ(all.depth, sum);
    EXPECT_EQ(all.blocker, trace::none);
    const trace::Occlusion one = trees->occlusion(ray({0.1, 0.2, -1}, {0, 0, 1}, 1.5), counts);
    EXPECT_EQ(one.depth, scene->materials()[scene->all_objects()[0].surface.material].shadow_depth);
}

}  // namespace
}  // namespace irt
