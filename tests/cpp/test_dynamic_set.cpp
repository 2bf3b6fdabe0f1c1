// SPDX-License-Identifier: Apache-2.0
// Queries that know the dynamic set, against every object of the scene judged one by one.
#include <gtest/gtest.h>

#include "irt/trace/candidate.h"
#include "irt/trace/judge_primitive.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

/// The nearest hit of those on objects that `counts` says count, no farther than `limit`.
template <class Counts>
trace::Hit nearest_of(const Scene& scene, const trace::Ray& ray, const trace::Hit& limit,
                      Counts&& counts) {
    trace::Hit best = limit;
    const trace::JudgeRay world = trace::judge_ray(ray);
    for (std::uint32_t slot = 0; slot < scene.slot_count(); ++slot) {
        const ObjectSlot& object = scene.all_objects()[slot];
        if (!object.live || !counts(slot)) continue;
        const std::uint32_t primitives = trace::primitive_count(object.surface);
        for (std::uint32_t k = 0; k < primitives; ++k) {
            trace::Hit hit;
            hit.object = slot;
            if (!trace::judge_primitive(object.surface, k, world, hit)) continue;
            if (!best && std::isinf(best.t))
                best = hit;
            else
                trace::take_if_nearer(scene, hit, best);
        }
    }
    return best;
}

TEST(DynamicSet, QueriesAnswerAsTheObjectsJudgedOneByOne) {
    std::size_t behind_found = 0, moving_found = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        Random random(seed);
        SceneBuilder builder;
        const auto place = [&] {
            const V3d p = random.point() * 3;
            // On a coarse lattice, so that many hits tie.
            return random.below(2) == 0
                       ? translation({std::round(p.x), std::round(p.y), std::round(p.z)})
                       : random.transform(3);
        };
        const auto geometry = [&]() -> Geometry {
            if (random.below(3) == 0) return std::shared_ptr<const Mesh>(box());
            return random_solid(random);
        };
        for (int i = 0; i < 14; ++i) builder.add(geometry(), place());
        Scene scene{V3d(0, 0, 0)};
        trace::Intersector found;
        found.commit(scene, scene.apply(builder.changes()).geometry);
        for (int edit = 0; edit < 5; ++edit) {
            ChangeSet change;
            const std::string path = "/o" + std::to_string(random.below(14));
            change.objects[path] = Object{geometry(), place(), "glass"};
            if (random.below(4) == 0) change.objects[path] = std::nullopt;
            found.commit(scene, scene.apply(change).geometry);
            for (int i = 0; i < 300; ++i) {
                const V3d from = random.point() * 6;
                V3d towards = random.point() * 3;
                if (random.below(2) == 0)
                    towards = {std::round(towards.x), std::round(towards.y), std::round(towards.z)};
                const trace::Ray ray = test::ray(from, towards - from);
                trace::QueryCounts counts;
                trace::Hit behind;
                const trace::Hit best = found.nearest_and_behind(ray, behind, counts);
                const auto all = [](std::uint32_t) { return true; };
                EXPECT_TRUE(same(best, nearest_of(scene, ray, {}, all)));
                EXPECT_TRUE(same(behind, nearest_of(scene, ray, {}, [&](std::uint32_t slot) {
                                     return !found.moves(slot) && slot != best.object;
                                 })));
                trace::Hit limit = behind;
                if (random.below(3) == 0) limit = {};
                const trace::Hit moving = found.nearest_moving(ray, limit, counts);
                EXPECT_TRUE(same(moving, nearest_of(scene, ray, limit, [&](std::uint32_t slot) {
                                     return found.moves(slot);
                                 })));
                behind_found += static_cast<bool>(behind);
                moving_found += moving && !same(moving, limit);
            }
        }
    }
    EXPECT_GT(behind_found, 1000u);
    EXPECT_GT(moving_found, 300u);
}

}  // namespace
}  // namespace irt
