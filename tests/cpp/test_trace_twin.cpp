// SPDX-License-Identifier: Apache-2.0
// The Embree path against its brute-force twin, bit for bit, on random scenes.
#include <gtest/gtest.h>

#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

std::shared_ptr<Prototype> random_prototype(Random& random) {
    auto prototype = std::make_shared<Prototype>();
    for (std::size_t i = 0; i <= random.below(3); ++i) {
        Part part;
        part.name = "p" + std::to_string(i);
        if (random.below(2) == 0)
            part.geometry = random_solid(random);
        else
            part.geometry = std::shared_ptr<const Mesh>(ball(4, 5));
        part.prototype_from_part = random.transform(1);
        part.material = i == 0 ? "opaque" : "glass";
        prototype->parts.push_back(part);
    }
    return prototype;
}

/// Random objects, a third of them copies of an earlier one in the same place.
ChangeSet random_scene(Random& random, double spread) {
    SceneBuilder builder;
    const char* const materials[] = {"opaque", "glass", "red glass"};
    std::vector<Object> made;
    const auto prototype = random_prototype(random);
    const std::shared_ptr<const Mesh> shapes[] = {ball(5, 6), box(), board(4, 0.5), pawn(5, 6)};
    const std::size_t count = 3 + random.below(12);
    for (std::size_t i = 0; i < count; ++i) {
        Object object;
        if (!made.empty() && random.below(3) == 0) {
            object = made[random.below(made.size())];
        } else {
            switch (random.below(4)) {
                case 0:
                    object.geometry = shapes[random.below(4)];
                    break;
                case 1:
                    object.geometry = std::shared_ptr<const Prototype>(prototype);
                    break;
                default:
                    object.geometry = random_solid(random);
            }
            // Some aligned to the grid, so that surfaces of different objects coincide.
            if (random.below(2) == 0) {
                const V3d p = random.point() * spread;
                object.world_from_object =
                    translation({std::round(p.x), std::round(p.y), std::round(p.z)});
            } else {
                object.world_from_object = random.transform(spread);
            }
        }
        made.push_back(object);
        builder.add(object.geometry, object.world_from_object, materials[random.below(3)]);
    }
    return builder.changes();
}

trace::Ray random_ray(Random& random, double spread) {
    const V3d from = random.point() * spread * 2;
    V3d towards = random.point() * spread;
    switch (random.below(4)) {
        case 0: {  // along an axis, on the grid
            V3d o(std::round(from.x), std::round(from.y), std::round(from.z)), d(0, 0, 0);
            d[static_cast<int>(random.below(3))] = random() < 0 ? -1 : 1;
            return ray(o, d);
        }
        case 1:  // aimed at a grid point, from a grid point
            return ray({std::round(from.x), std::round(from.y), std::round(from.z)},
                       V3d(std::round(towards.x), std::round(towards.y), std::round(towards.z)) -
                           V3d(std::round(from.x), std::round(from.y), std::round(from.z)) +
                           V3d(0, 0, 1e-30));
        case 2:  // from far away
            towards -= from * 1000;
            return ray(from * 1000, towards);
        default:
            return ray(from, towards - from, random.below(2) == 0 ? 1 : 1e30);
    }
}

void expect_twins(const Scene& scene, const trace::Intersector& found, Random& random, int rays,
                  double spread, const std::string& what) {
    trace::QueryCounts counts;
    for (int i = 0; i < rays; ++i) {
        const trace::Ray r = random_ray(random, spread);
        const trace::Hit hit = found.nearest(r, counts), twin = brute_force_nearest(scene, r);
        ASSERT_TRUE(same(hit, twin))
            << what << ", ray " << i << ": t " << hit.t << " object " << hit.object << ", twin "
            << twin.t << " object " << twin.object;
        const trace::Occlusion dark = found.occlusion(r, counts),
                               twin_dark = brute_force_occlusion(scene, r);
        ASSERT_EQ(dark.depth, twin_dark.depth) << what << ", ray " << i;
        ASSERT_EQ(dark.blocker == trace::none, twin_dark.blocker == trace::none) << what;
    }
}

TEST(Twin, RandomScenesAgreeBitForBit) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Random random(seed);
        Scene scene(V3d(0, 0, 0));
        scene.apply(random_scene(random, 4));
        const std::string isa = seed % 4 == 3 ? "sse2" : "avx2";
        const auto found =
            intersector(scene, {seed % 2 == 1, static_cast<std::uint32_t>(seed % 3)}, isa);
        expect_twins(scene, *found, random, 400, 4, "seed " + std::to_string(seed));
    }
}

TEST(Twin, EveryScaleAgrees) {
    for (const double scale : {1e-6, 1e-3, 1e3, 1e6, 1e9}) {
        Random random(7);
        ChangeSet changes = random_scene(random, 4);
        for (auto& [path, object] : changes.objects)
            object->world_from_object = object->world_from_object * scaling(V3d(scale));
        Scene scene(V3d(0, 0, 0));
        scene.apply(changes);
        const auto found = intersector(scene);
        trace::QueryCounts counts;
        int hits = 0;
        for (int i = 0; i < 2000; ++i) {
            trace::Ray r = random_ray(random, 4);
            r.origin *= static_cast<float>(scale);
            if (i % 2 == 0) r = trace::make_ray(r.origin, r.direction * static_cast<float>(scale));
            const trace::Hit hit = found->nearest(r, counts);
            hits += hit ? 1 : 0;
            ASSERT_TRUE(same(hit, brute_force_nearest(scene, r))) << scale << " ray " << i;
        }
        EXPECT_GT(hits, 100) << scale;
    }
}

/// Commits that follow edits answer like a tree built at once, whatever was folded or retired.
TEST(Twin, CommitsFollowEdits) {
    for (std::uint64_t seed = 100; seed < 110; ++seed) {
        Random random(seed);
        const ChangeSet all = random_scene(random, 4);
        Scene scene(V3d(0, 0, 0));
        trace::Intersector found("avx2", 1);
        found.commit(scene, scene.apply(all).geometry);
        for (int edit = 0; edit < 12; ++edit) {
            ChangeSet change;
            for (const auto& [path, object] : all.objects) {
                if (random.below(4) != 0) continue;
                if (random.below(3) == 0) {
                    change.objects[path] = std::nullopt;
                } else {
                    change.objects[path] = object;
                    change.objects[path]->world_from_object =
                        object->world_from_object *
                        translation(random.point() * (edit == 7 ? 50 : 1));
                }
            }
            found.commit(scene, scene.apply(change).geometry);
            expect_twins(scene, found, random, 150, 4,
                         "seed " + std::to_string(seed) + ", edit " + std::to_string(edit));
        }
    }
}

TEST(Twin, EmptySceneAnswersNothing) {
    Scene scene(V3d(0, 0, 0));
    trace::Intersector found;
    trace::QueryCounts counts;
    EXPECT_FALSE(found.nearest(ray({0, 0, 0}, {0, 0, 1}), counts));
    found.commit(scene, {});
    const trace::Hit hit = found.nearest(ray({0, 0, 0}, {0, 0, 1}), counts);
    EXPECT_FALSE(hit);
    EXPECT_TRUE(std::isinf(hit.t));
    EXPECT_EQ(found.occlusion(ray({0, 0, 0}, {0, 0, 1}), counts).depth, trace::OpticalDepth{});
}

TEST(Isa, UnknownAndMissingOnesAreRefused) {
    EXPECT_THROW(trace::Intersector("mmx"), std::invalid_argument);
    if (trace::best_isa() != "avx512") {
        EXPECT_THROW(trace::Intersector("avx512"), std::invalid_argument);
    }
    EXPECT_NO_THROW(trace::Intersector(trace::best_isa()));
}

}  // namespace
}  // namespace irt
