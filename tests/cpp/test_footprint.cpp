// SPDX-License-Identifier: Apache-2.0
// Paths and footprints as a pair (DESIGN 3, rule 8): whatever a ray hits, the ray's path may meet
// the footprint of what it hit.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "irt/history/voxel_grid.h"
#include "irt/trace/judge_primitive.h"
#include "irt/update/footprint.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

/// The nearest hit of `ray` on one object, or none.
trace::Hit hit_on(const ObjectSlot& object, const trace::Ray& ray) {
    trace::JudgeRay local = trace::judge_ray(ray);
    if (object.prototype)
        trace::transform_ray(object.prototype_from_render, trace::JudgeRay(local), local);
    trace::Hit nearest;
    const std::size_t parts = object.prototype ? object.prototype->surfaces.size() : 1;
    for (std::uint32_t part = 0; part < parts; ++part) {
        const Surface& surface = object.part(part);
        const std::uint32_t primitives = trace::primitive_count(surface);
        for (std::uint32_t k = 0; k < primitives; ++k) {
            trace::Hit hit;
            hit.object = 0;
            if (trace::judge_primitive(surface, k, local, hit) && hit.t < nearest.t) nearest = hit;
        }
    }
    return nearest;
}

/// A tilted square a hundred voxels wide of two triangles: its box holds the whole grid.
std::shared_ptr<Mesh> sheet() { return board(1, 40); }

Geometry random_geometry(Random& random) {
    switch (random.below(10)) {
        case 0:
            return std::shared_ptr<const Mesh>(ball(5, 6));
        case 1:
            return std::shared_ptr<const Mesh>(box());
        case 2:
            return std::shared_ptr<const Mesh>(sheet());
        case 3: {
            auto prototype = std::make_shared<Prototype>();
            prototype->parts.push_back({"q", random_solid(random), M44d(), "opaque"});
            prototype->parts.push_back(
                {"m", std::shared_ptr<const Mesh>(box()), random.transform(1), "opaque"});
            return std::shared_ptr<const Prototype>(prototype);
        }
        default:
            return random_solid(random);
    }
}

/// The point of a grid's voxel corner: where rounding decides which voxel it is in.
V3d corner(const history::VoxelGrid& grid, Random& random) {
    const V3d zero = grid.in_voxels(V3d(0)), unit = grid.in_voxels(V3d(1)) - zero;
    V3d at;
    for (int a = 0; a < 3; ++a)
        at[a] = (static_cast<double>(random.below(history::grid_side + 1)) - zero[a]) / unit[a];
    return at;
}

/// How a scene's objects and the grid lie to each other.
enum class Setting { Loose, OnVoxelFaces, MostlyOutside };

/// Calls check(object, path) for segments that end at a hit, and for those that go on behind it.
std::size_t for_each_hit(
    Setting setting, std::uint64_t seed, std::size_t rays,
    const std::function<void(bool may_meet, const ObjectSlot& object)>& check) {
    Random random(seed);
    trace::Box box;
    box.extend(V3d(-4, -4, -4));
    box.extend(V3d(4, 4, 4));
    if (setting == Setting::MostlyOutside) box = {V3d(-1, -1, -1), V3d(1, 1, 1)};
    const history::VoxelGrid grid(box);
    const V3d voxel = V3d(1) / (grid.in_voxels(V3d(1)) - grid.in_voxels(V3d(0)));
    SceneBuilder builder;
    for (int i = 0; i < 8; ++i) {
        M44d placed = random.transform(4);
        if (setting == Setting::OnVoxelFaces) {
            // Whole voxels in size, centred on a corner: all faces lie on faces of voxels.
            const auto whole = [&] { return static_cast<double>(1 + random.below(4)); };
            placed =
                scaling(voxel * V3d(whole(), whole(), whole())) * translation(corner(grid, random));
        }
        builder.add(random_geometry(random), placed);
    }
    const auto scene = builder.scene();
    std::vector<history::Regions> regions;
    for (const ObjectSlot& object : scene->all_objects()) {
        update::Footprints footprint(grid, 1);
        footprint.add(*scene, object.slot);
        regions.push_back(footprint.regions());
    }
    update::Footprints many(grid, 1000);
    for (const ObjectSlot& object : scene->all_objects()) many.add(*scene, object.slot);
    const history::Regions together = many.regions();

    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays; ++i) {
        V3d from = random.point() * 9, towards = random.point() * 4;
        if (random.below(2) == 0) towards = corner(grid, random);
        if (random.below(3) == 0) from = corner(grid, random);
        if (random.below(3) == 0) {  // along an axis
            const int axis = static_cast<int>(random.below(3));
            const double far = towards[axis];
            towards = from;
            towards[axis] = far;
        }
        if (random.below(8) == 0) from *= 1000;
        const trace::Ray ray = test::ray(from, towards - from + V3d(0, 0, 1e-30));
        for (std::size_t k = 0; k < scene->slot_count(); ++k) {
            const ObjectSlot& object = scene->all_objects()[k];
            const trace::Hit hit = hit_on(object, ray);
            if (!hit) continue;
            ++hits;
            for (const double end : {hit.t, 1.5 * hit.t, std::numeric_limits<double>::infinity()}) {
                const history::Path path = grid.path(ray.origin, ray.direction, end);
                check(regions[k].may_meet(path) && together.may_meet(path), object);
            }
        }
    }
    return hits;
}

void expect_every_hit_met(Setting setting) {
    std::size_t hits = 0, missed = 0;
    std::string first_missed;
    for (std::uint64_t seed = 0; hits < 100000; ++seed)
        hits += for_each_hit(setting, seed, 4000, [&](bool may_meet, const ObjectSlot& object) {
            if (may_meet) return;
            if (missed++ == 0) first_missed = object.path + " of seed " + std::to_string(seed);
        });
    EXPECT_EQ(missed, 0u) << first_missed;
}

TEST(Footprint, IsMetByEveryRayThatHits) { expect_every_hit_met(Setting::Loose); }
TEST(Footprint, IsMetByRaysThatHitOnFacesOfVoxels) { expect_every_hit_met(Setting::OnVoxelFaces); }
TEST(Footprint, IsMetByRaysThatHitOutsideTheGrid) { expect_every_hit_met(Setting::MostlyOutside); }

TEST(Footprint, OfABigThinPlaneLeavesMostVoxelsOut) {
    trace::Box box;
    box.extend(V3d(-4, -4, -4));
    box.extend(V3d(4, 4, 4));
    const history::VoxelGrid grid(box);
    SceneBuilder builder;
    builder.add(std::shared_ptr<const Mesh>(sheet()), rotation(0, 0.7) * rotation(1, 0.6));
    const auto scene = builder.scene();
    update::Footprints footprint(grid, 1);
    footprint.add(*scene, 0);
    const history::Regions regions = footprint.regions();
    std::size_t met = 0, all = 0;
    for (history::Path voxel = 0; voxel < history::voxel_count; voxel += 7, ++all)
        met += regions.may_meet(voxel | voxel << history::voxel_bits);
    EXPECT_GT(met, all / 100);
    EXPECT_LT(met, all / 2);
}

TEST(Footprint, OfWhatIsNotThereIsEmpty) {
    const history::VoxelGrid grid;
    update::Footprints footprint(grid, 1);
    SceneBuilder builder;
    builder.add(quadric(QuadricKind::Sphere), M44d());
    const auto scene = builder.scene();
    ChangeSet removal;
    removal.objects["/o0"].reset();
    scene->apply(removal);
    footprint.add(*scene, 0);
    EXPECT_TRUE(footprint.regions().empty());
}

}  // namespace
}  // namespace irt
