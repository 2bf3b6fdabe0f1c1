// SPDX-License-Identifier: Apache-2.0
// Scenes and rays that the trace tests and the exact-hits trial share.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "irt/scene/scene.h"
#include "irt/trace/intersector.h"
#include "trace_shapes.h"

namespace irt::test {

/// Collects objects of three materials ("opaque", "glass", "red glass") and makes the scene.
class SceneBuilder {
  public:
    SceneBuilder() {
        Material opaque, glass, red;
        glass.opacity = 0;
        glass.diffuse_color = V3f(0.5f, 0.25f, 0.75f);
        red.opacity = 0.25f;
        red.diffuse_color = V3f(1, 0.5f, 0);
        changes_.materials = {{"opaque", opaque}, {"glass", glass}, {"red glass", red}};
    }
    void add(Geometry geometry, const M44d& world_from_object,
             const std::string& material = "opaque") {
        changes_.objects["/o" + std::to_string(count_++)] =
            Object{std::move(geometry), world_from_object, material};
    }
    [[nodiscard]] const ChangeSet& changes() const { return changes_; }
    [[nodiscard]] std::unique_ptr<Scene> scene(const V3d& render_origin = V3d(0, 0, 0)) const {
        auto scene = std::make_unique<Scene>(render_origin);
        scene->apply(changes_);
        return scene;
    }

  private:
    ChangeSet changes_;
    int count_ = 0;
};

inline Affine affine(const M44d& m) {
    Affine rows;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 3; ++j) rows[static_cast<std::size_t>(3 * i + j)] = m[i][j];
    return rows;
}

using PrototypePointer = std::shared_ptr<const Prototype>;
using ArrayPointer = std::shared_ptr<const InstanceArray>;

inline PrototypePointer prototype(std::vector<Part> parts) {
    return std::make_shared<const Prototype>(Prototype{std::move(parts)});
}

/// Tiles that meet edge to edge on z = 0, some of them twice.
inline ArrayPointer tile_array() {
    auto array = std::make_shared<InstanceArray>();
    const std::shared_ptr<const Mesh> tile = board(4, 0.5);
    array->prototypes = {prototype({{"tile", tile, M44d(), "opaque"}}),
                         prototype({{"tile", tile, M44d(), "red glass"}})};
    for (int i = 0; i < 64; ++i)
        for (int copy = 0; copy < (i % 7 == 0 ? 2 : 1); ++copy) {
            array->array_from_prototype.push_back(
                affine(translation({(i % 8) * 2.0 - 7, (i / 8) * 2.0 - 7, 0})));
            array->prototype_of.push_back(i % 3 == 0 ? 1 : 0);
        }
    return array;
}

/// Of three prototypes, in place and size at random, some coincident, with keys that leave gaps.
inline std::shared_ptr<InstanceArray> random_array(Random& random, int count) {
    auto array = std::make_shared<InstanceArray>();
    const std::shared_ptr<const Mesh> mesh = ball(6, 8), cube = box();
    array->prototypes = {
        prototype({{"mesh", mesh, M44d(), "opaque"},
                   {"cone", quadric(QuadricKind::Cone), translation({0, 2, 0}), "red glass"}}),
        prototype({{"sphere", quadric(QuadricKind::Sphere), M44d(), "glass"}}),
        prototype({{"box", cube, scaling(V3d(0.5)), "opaque"}})};
    for (int i = 0; i < count; ++i) {
        const V3d p = random.point() * 5;
        array->array_from_prototype.push_back(
            i > 0 && random.below(4) == 0 ? array->array_from_prototype.back()
            : random.below(3) == 0
                ? affine(translation({std::round(p.x), std::round(p.y), std::round(p.z)}))
                : affine(random.transform(5)));
        array->prototype_of.push_back(static_cast<std::uint32_t>(random.below(3)));
        array->keys.push_back((array->keys.empty() ? -7 : array->keys.back()) + 1 +
                              static_cast<std::int64_t>(random.below(3)));
    }
    return array;
}

/// Instances of instances, three deep, with shapes of their own between.
inline ArrayPointer nested_array(Random& random) {
    ArrayPointer inner = random_array(random, 6);
    for (int depth = 0; depth < 2; ++depth) {
        auto outer = std::make_shared<InstanceArray>();
        outer->prototypes = {
            prototype({{"inner", inner, scaling(V3d(0.4)), ""},
                       {"box", std::shared_ptr<const Mesh>(box()), scaling(V3d(0.3)), "opaque"},
                       {"again", inner, scaling(V3d(0.3)) * translation({1, 0, 0}), ""}}),
            prototype({{"plane", quadric(QuadricKind::Plane), M44d(), "glass"}})};
        for (int i = 0; i < 4; ++i) {
            outer->array_from_prototype.push_back(affine(random.transform(3)));
            outer->prototype_of.push_back(i % 3 == 2 ? 1 : 0);
        }
        inner = outer;
    }
    return inner;
}

inline std::vector<std::uint32_t> all_slots(const Scene& scene) {
    std::vector<std::uint32_t> slots(scene.slot_count());
    for (std::uint32_t i = 0; i < slots.size(); ++i) slots[i] = i;
    return slots;
}

inline std::unique_ptr<trace::Intersector> intersector(const Scene& scene,
                                                       trace::TreeOptions options = {},
                                                       const std::string& isa = "avx2") {
    auto made = std::make_unique<trace::Intersector>(isa, 0, options);
    made->commit(scene, all_slots(scene));
    return made;
}

inline bool same_bits(double a, double b) { return __builtin_memcmp(&a, &b, sizeof a) == 0; }

inline bool same(const trace::Hit& a, const trace::Hit& b) {
    return same_bits(a.t, b.t) && same_bits(a.u, b.u) && same_bits(a.v, b.v) &&
           a.object == b.object && a.part == b.part && a.primitive == b.primitive &&
           a.piece == b.piece;
}

inline trace::Ray ray(const V3d& origin, const V3d& direction,
                      double t_max = std::numeric_limits<double>::infinity()) {
    return trace::make_ray(V3f(origin), V3f(direction), static_cast<float>(t_max));
}

}  // namespace irt::test
