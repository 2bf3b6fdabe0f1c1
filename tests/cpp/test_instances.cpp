// SPDX-License-Identifier: Apache-2.0
// Instance arrays: which entries an edit changes, and that trees which follow edits answer as trees
// made anew and as the twin without trees.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "irt/scene/foreseen.h"
#include "irt/scene/primvar.h"
#include "irt/trace/judge_primitive.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

const M44d identity;

SceneBuilder with_array(const InstanceArray& array) {
    SceneBuilder builder;
    builder.add(std::make_shared<const InstanceArray>(array), identity);
    builder.add(quadric(QuadricKind::Sphere), translation({0, 0, 3}));
    return builder;
}

/// The names of all that `applied` changed, as the scene now has them, and of what went, "gone".
std::multiset<std::string> changed(const Scene& scene, const AppliedChanges& applied) {
    std::multiset<std::string> names;
    for (const std::uint32_t slot : applied.geometry)
        names.insert(scene.live(slot) ? scene.name(slot) : "gone");
    return names;
}

AppliedChanges set_array(Scene& scene, const InstanceArray& array, const M44d& m = identity) {
    ChangeSet changes;
    changes.objects["/o0"] = Object{std::make_shared<const InstanceArray>(array), m, "", {}};
    return scene.apply(changes);
}

InstanceArray row(int count) {
    InstanceArray array;
    array.prototypes = {prototype({{"ball", quadric(QuadricKind::Sphere), identity, "opaque"}}),
                        prototype({{"box", quadric(QuadricKind::Cube), identity, "opaque"}})};
    for (int i = 0; i < count; ++i) {
        array.array_from_prototype.push_back(affine(translation({i * 3.0, 0, 0})));
        array.prototype_of.push_back(0);
    }
    return array;
}

TEST(Instances, AnEntryChangesWhereItsBitsDo) {
    InstanceArray array = row(5);
    SceneBuilder builder;
    const auto scene = builder.scene();
    EXPECT_EQ(set_array(*scene, array).geometry.size(), 5u);
    EXPECT_TRUE(set_array(*scene, array).empty());

    array.array_from_prototype[3] = affine(translation({9, 1, 0}));
    EXPECT_EQ(changed(*scene, set_array(*scene, array)), (std::multiset<std::string>{"/o0[3]"}));
    array.prototype_of[1] = 1;
    EXPECT_EQ(changed(*scene, set_array(*scene, array)), (std::multiset<std::string>{"/o0[1]"}));

    // The same entries by other prototype indices, and with keys written out.
    std::swap(array.prototypes[0], array.prototypes[1]);
    for (std::uint32_t& prototype : array.prototype_of) prototype = 1 - prototype;
    array.keys = {0, 1, 2, 3, 4};
    EXPECT_TRUE(set_array(*scene, array).empty());

    EXPECT_EQ(set_array(*scene, array, translation({0, 1, 0})).geometry.size(), 5u);
}

TEST(Instances, KeysTellEntriesApartWhereverTheyStand) {
    InstanceArray array = row(4);
    array.keys = {2, 4, 6, 9};
    SceneBuilder builder;
    const auto scene = builder.scene();
    set_array(*scene, array);
    const std::vector<std::uint32_t> slots = scene->entry_slots(scene->object(0));

    // 4 goes, 5 comes.
    array.keys = {2, 5, 6, 9};
    const AppliedChanges applied = set_array(*scene, array);
    EXPECT_EQ(changed(*scene, applied), (std::multiset<std::string>{"/o0[5]", "gone"}));
    ASSERT_EQ(applied.former.size(), 1u);
    EXPECT_EQ(applied.former[0].entries, std::vector<std::uint32_t>{1});
    EXPECT_FALSE(scene->live(slots[1]));

    // 4 is back under its slot.
    array.keys = {2, 4, 6, 9};
    set_array(*scene, array);
    EXPECT_EQ(scene->entry_slots(scene->object(0)), slots);
    EXPECT_EQ(scene->name(slots[1]), "/o0[4]");
    EXPECT_NE(scene->id(slots[1]), scene->id(slots[2]));
}

TEST(Instances, WhatDoesNotFitIsRefusedAndNothingApplied) {
    const auto refused = [](auto&& spoil) {
        InstanceArray array = row(3);
        spoil(array);
        const auto scene = SceneBuilder().scene();
        EXPECT_THROW(set_array(*scene, array), std::invalid_argument);
        EXPECT_EQ(scene->slot_count(), 0u);
    };
    refused([](InstanceArray& a) { a.prototype_of[1] = 2; });
    refused([](InstanceArray& a) { a.prototype_of.pop_back(); });
    refused([](InstanceArray& a) { a.keys = {0, 1}; });
    refused([](InstanceArray& a) { a.keys = {0, 2, 2}; });
    refused([](InstanceArray& a) { a.array_from_prototype[2][0] = 0; });
    refused([](InstanceArray& a) { a.array_from_prototype[2][9] = std::nan(""); });
    refused([](InstanceArray& a) { a.prototypes.clear(); });

    // 65536 x 65536 parts do not have numbers of 32 bits.
    InstanceArray many = row(1);
    many.prototype_of.clear();
    many.array_from_prototype.resize(65536, affine(identity));
    ArrayPointer nest = std::make_shared<const InstanceArray>(many);
    for (int depth = 0; depth < 2; ++depth) {
        InstanceArray outer = many;
        outer.prototypes = {prototype({{"nest", nest, identity, "", {}}})};
        nest = std::make_shared<const InstanceArray>(outer);
    }
    const auto scene = SceneBuilder().scene();
    EXPECT_THROW(set_array(*scene, *nest), std::invalid_argument);
}

/// Rays at what is there, and in random directions.
trace::Ray random_ray(Random& random) {
    const V3d from = random.point() * 8;
    return ray(from, random.below(2) == 0 ? random.direction() : random.point() * 3 - from);
}

void edit(InstanceArray& array, Random& random) {
    for (std::uint64_t edits = 1 + random.below(3); edits > 0; --edits) {
        const std::size_t entry = random.below(array.size());
        const auto at = static_cast<std::ptrdiff_t>(entry);
        switch (random.below(5)) {
            case 0:
                array.array_from_prototype[entry] = affine(random.transform(5));
                break;
            case 1:  // into another's place
                array.array_from_prototype[entry] =
                    array.array_from_prototype[random.below(array.size())];
                break;
            case 2:
                array.prototype_of[entry] = static_cast<std::uint32_t>(random.below(3));
                break;
            case 3:
                if (array.size() < 3) break;
                array.array_from_prototype.erase(array.array_from_prototype.begin() + at);
                array.prototype_of.erase(array.prototype_of.begin() + at);
                array.keys.erase(array.keys.begin() + at);
                break;
            default:
                array.array_from_prototype.push_back(affine(random.transform(5)));
                array.prototype_of.push_back(static_cast<std::uint32_t>(random.below(3)));
                array.keys.push_back(array.keys.back() + 1);
        }
    }
}

TEST(Instances, TreesThatFollowEditsAnswerAsNewOnesAndAsTheTwin) {
    std::size_t hits = 0, shadows = 0;
    std::uint32_t foldings = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Random random(seed);
        const auto array = random_array(random, 24);
        SceneBuilder builder = with_array(*array);
        builder.add(nested_array(random), identity);
        const auto scene = builder.scene();
        trace::Intersector kept("avx2", 0, {false, seed % 2 == 0 ? 0u : 5u});
        kept.commit(*scene, all_slots(*scene));
        for (int step = 0; step < 6; ++step) {
            if (step > 0) {
                edit(*array, random);
                const M44d m = random.below(4) == 0 ? translation(random.point()) : identity;
                const AppliedChanges applied = set_array(*scene, *array, m);
                kept.commit(*scene, applied.geometry);
            }
            const auto fresh = intersector(*scene);
            trace::QueryCounts counts;
            for (int i = 0; i < 300; ++i) {
                const trace::Ray r = random_ray(random);
                const trace::Hit hit = kept.nearest(r, counts);
                hits += static_cast<bool>(hit);
                ASSERT_TRUE(same(hit, fresh->nearest(r, counts)));
                ASSERT_TRUE(same(hit, brute_force_nearest(*scene, r)));
                if (hit) {
                    ASSERT_TRUE(same(hit, trace::named_hit(*scene, r, trace::HitName(hit))));
                }
                const trace::Occlusion dark = kept.occlusion(r, counts);
                shadows += dark.blocker != trace::none;
                ASSERT_EQ(dark.depth, brute_force_occlusion(*scene, r).depth);
            }
        }
        foldings += kept.epoch();
    }
    EXPECT_GT(hits, 3000u);
    EXPECT_GT(shadows, 1000u);
    EXPECT_GT(foldings, 12u);
}

TEST(Instances, OneThatMovesLeavesTheTreeOverTheOthersAlone) {
    InstanceArray array = row(20000);
    const auto scene = SceneBuilder().scene();
    set_array(*scene, array);
    trace::Intersector trees;
    trees.commit(*scene, all_slots(*scene));
    const std::uint32_t epoch = trees.epoch();
    trace::QueryCounts counts;
    const trace::Ray at_7 = ray({21, 0, 5}, {0, 0, -1}), at_8 = ray({24, 0, 5}, {0, 0, -1});
    for (int step = 1; step < 50; ++step) {
        array.array_from_prototype[7] = affine(translation({21, 0, -step * 0.01}));
        trees.commit(*scene, set_array(*scene, array).geometry);
        EXPECT_TRUE(trees.moves(7));
        EXPECT_FALSE(trees.moves(8));
        EXPECT_NEAR(trees.nearest(at_7, counts).t, 4 + step * 0.01, 1e-9);
        EXPECT_NEAR(trees.nearest(at_8, counts).t, 4, 1e-9);
        EXPECT_FALSE(trees.nearest_moving(at_8, trace::Hit(), counts));
    }
    EXPECT_EQ(trees.epoch(), epoch);
}

TEST(Instances, PrototypesMayStandInAnotherOrder) {
    InstanceArray array = row(4);
    array.prototype_of = {0, 1, 1, 0};
    const auto scene = SceneBuilder().scene();
    set_array(*scene, array);
    trace::Intersector trees;
    trees.commit(*scene, all_slots(*scene));
    std::swap(array.prototypes[0], array.prototypes[1]);
    for (std::uint32_t& prototype : array.prototype_of) prototype = 1 - prototype;
    const AppliedChanges applied = set_array(*scene, array);
    EXPECT_TRUE(applied.empty());
    trees.follow(applied);
    const auto fresh = intersector(*scene);
    trace::QueryCounts counts;
    Random random(8);
    for (int i = 0; i < 500; ++i) {
        const V3d from(random() * 12, 1.5 * random(), 5);
        const trace::Ray r = ray(from, {0.1 * random(), 0.1 * random(), -1});
        EXPECT_EQ(trees.nearest(r, counts).t, fresh->nearest(r, counts).t);
    }
}

/// Primvars by entry change how an entry shades, and nothing else.
TEST(Instances, PrimvarsAreReadWherePartsHaveNone) {
    InstanceArray array = row(3);
    array.keys = {2, 5, 9};
    array.primvars = {{"dye", Interpolation::Vertex, 2, {1, 2, 3, 4, 5, 6}, {}},
                      {"same", Interpolation::Constant, 1, {7}, {}}};
    const auto scene = SceneBuilder().scene();
    set_array(*scene, array);
    const auto value = [&](std::uint32_t slot, const char* name) {
        trace::Hit hit;
        hit.object = slot;
        return instance_primvar(*scene, hit, name);
    };
    EXPECT_EQ(value(1, "dye")->value[1], 4);
    EXPECT_EQ(value(1, "dye")->width, 2);
    EXPECT_EQ(value(2, "same")->value[0], 7);
    EXPECT_FALSE(value(0, "none"));

    array.primvars[0].values[3] = 8;
    AppliedChanges applied = set_array(*scene, array);
    EXPECT_TRUE(applied.geometry.empty());
    EXPECT_EQ(applied.rebound, std::vector<std::uint32_t>{1});
    EXPECT_EQ(value(1, "dye")->value[1], 8);
    // The same values by indices are no change.
    array.primvars[0].indices = {2, 0, 1};
    array.primvars[0].values = {3, 8, 5, 6, 1, 2};
    applied = set_array(*scene, array);
    EXPECT_TRUE(applied.empty());
    // An entry that goes takes its value along.
    array.keys.erase(array.keys.begin());
    array.prototype_of.pop_back();
    array.array_from_prototype.erase(array.array_from_prototype.begin());
    array.primvars[0].indices.erase(array.primvars[0].indices.begin());
    applied = set_array(*scene, array);
    EXPECT_EQ(applied.geometry, std::vector<std::uint32_t>{0});
    EXPECT_TRUE(applied.rebound.empty());
    EXPECT_EQ(value(1, "dye")->value[1], 8);

    // Nested: the inner array's come first.
    InstanceArray inner = row(2);
    inner.primvars = {{"own", Interpolation::Vertex, 1, {3, 4}, {}},
                      {"same", Interpolation::Constant, 1, {1}, {}}};
    InstanceArray outer = row(1);
    outer.primvars = {{"dye", Interpolation::Constant, 1, {9}, {}},
                      {"same", Interpolation::Constant, 1, {2}, {}}};
    outer.prototypes[0] =
        prototype({{"inner", std::make_shared<const InstanceArray>(inner), identity, ""}});
    const auto nested = SceneBuilder().scene();
    set_array(*nested, outer);
    trace::Hit hit;
    hit.object = 0;
    hit.part = 1;
    EXPECT_EQ(instance_primvar(*nested, hit, "own")->value[0], 4);
    EXPECT_EQ(instance_primvar(*nested, hit, "same")->value[0], 1);
    EXPECT_EQ(instance_primvar(*nested, hit, "dye")->value[0], 9);

    outer.primvars[0].interpolation = Interpolation::Uniform;
    EXPECT_THROW(set_array(*nested, outer), std::invalid_argument);
    outer.primvars[0] = {"dye", Interpolation::Vertex, 1, {1, 2}, {}};
    EXPECT_THROW(set_array(*nested, outer), std::invalid_argument);
}

TEST(Instances, ASurfacePointIsWhereTheRayMeetsIt) {
    Random random(3);
    SceneBuilder builder;
    builder.add(nested_array(random), random.transform(1));
    const auto scene = builder.scene({1, 2, 3});
    const auto trees = intersector(*scene);
    trace::QueryCounts counts;
    std::size_t hits = 0;
    for (int i = 0; i < 4000; ++i) {
        const V3d from = random.point() * 8 - V3d(1, 2, 3);
        const trace::Ray r = ray(from, random.point() - V3d(1, 2, 3) - from);
        const trace::Hit hit = trees->nearest(r, counts);
        if (!hit) continue;
        ++hits;
        const trace::SurfacePoint point = surface_point(*scene, r, hit);
        const V3d met = V3d(r.origin) + V3d(r.direction) * hit.t;
        EXPECT_LT((point.position - met).length(), 1e-5 * (1 + met.length()));
        EXPECT_NEAR(point.geometric_normal.length(), 1, 1e-12);
        EXPECT_EQ(point.front, V3d(r.direction).dot(point.geometric_normal) < 0);
    }
    EXPECT_GT(hits, 200u);
}

TEST(Instances, AShotForeseesEntriesOneByOne) {
    InstanceArray array = row(6);
    const auto scene = SceneBuilder().scene();
    const auto record = [](const InstanceArray& a) {
        return Object{std::make_shared<const InstanceArray>(a), identity, "", {}};
    };
    ChangeSet initial, later;
    initial.objects["/o0"] = record(array);
    InstanceArray moved = array;
    moved.array_from_prototype[2] = affine(translation({6, 2, 0}));
    later.objects["/o0"] = record(moved);
    Foreseen foreseen(initial);
    foreseen.add(later);
    scene->apply(initial);
    for (std::uint32_t slot = 0; slot < 6; ++slot)
        EXPECT_EQ(foreseen.object_changes(*scene, slot), slot == 2);

    const std::vector<LightSlot> dark;
    EXPECT_TRUE(foreseen.covers(*scene, scene->apply(later), dark));
    moved.array_from_prototype[2] = affine(translation({6, 3, 0}));
    EXPECT_FALSE(foreseen.covers(*scene, set_array(*scene, moved), dark));
    set_array(*scene, array);
    array.array_from_prototype.pop_back();
    array.prototype_of.pop_back();
    EXPECT_FALSE(foreseen.covers(*scene, set_array(*scene, array), dark));
}

}  // namespace
}  // namespace irt
