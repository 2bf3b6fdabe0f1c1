// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/foreseen.h"

#include <algorithm>

#include "irt/scene/equality.h"
#include "irt/trace/judge_many.h"

namespace irt {

namespace {

/// Boxes an object may have before they become one.
constexpr std::size_t most_boxes = 64;

void extend(trace::Box& box, const std::vector<Ball>& balls, const M44d& world_from_shape) {
    for (const Ball& ball : balls) box.extend(trace::ball_box(ball, world_from_shape));
}

void extend(trace::Box& box, const Geometry& geometry, const M44d& world_from_shape) {
    if (const auto* quadric = std::get_if<Quadric>(&geometry)) {
        const V3d centre = transform_point(world_from_shape, V3d(0));
        const V3d half = trace::quadric_half_extent(*quadric, world_from_shape);
        box.extend(centre - half);
        box.extend(centre + half);
    } else if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&geometry)) {
        for (const V3f& p : (*mesh)->points) box.extend(transform_point(world_from_shape, V3d(p)));
    } else if (const auto* spheres = std::get_if<std::shared_ptr<const Spheres>>(&geometry)) {
        extend(box, (*spheres)->balls, world_from_shape);
    } else if (const auto* curves = std::get_if<std::shared_ptr<const Curves>>(&geometry)) {
        extend(box, (*curves)->balls, world_from_shape);
    } else {
        for (const Part& part : std::get<std::shared_ptr<const Prototype>>(geometry)->parts)
            extend(box, part.geometry, part.prototype_from_part * world_from_shape);
    }
}

trace::Box world_box(const Object& object) {
    trace::Box box;
    extend(box, object.geometry, object.world_from_object);
    return box;
}

bool lit(const Light& light) { return light.energy != V3f(0, 0, 0); }

}  // namespace

Foreseen::Foreseen(const ChangeSet& initial) {
    for (const auto& [path, record] : initial.lights)
        if (record) lights_.emplace(path, *record);
}

void Foreseen::add(const ChangeSet& changes) {
    for (const auto& [path, record] : changes.objects) {
        std::vector<trace::Box>& boxes = boxes_[path];
        if (!record) continue;
        const trace::Box box = world_box(*record);
        if (!box.empty()) boxes.push_back(box);
        if (boxes.size() <= most_boxes) continue;
        for (const trace::Box& other : boxes) boxes.front().extend(other);
        boxes.resize(1);
    }
    for (const auto& [name, record] : changes.materials) materials_.insert(name);
    for (const auto& [path, record] : changes.lights) {
        const auto known = lights_.find(path);
        lights_move_ = lights_move_ || !record || known == lights_.end() ||
                       !same_but_energy(known->second, *record) ||
                       lit(known->second) != lit(*record);
        if (record) lights_[path] = *record;
    }
}

bool Foreseen::covers(const Scene& scene, const AppliedChanges& applied,
                      const std::vector<LightSlot>& old_lights) const {
    const auto foreseen = [&](std::uint32_t slot) {
        const ObjectSlot& object = scene.objects()[slot];
        const auto found = boxes_.find(object.path);
        if (found == boxes_.end()) return false;
        if (!object.live) return true;
        const trace::Box box = world_box(object.record);
        return box.empty() ||
               std::any_of(found->second.begin(), found->second.end(), [&](const trace::Box& b) {
                   return b.lower.x <= box.lower.x && b.lower.y <= box.lower.y &&
                          b.lower.z <= box.lower.z && b.upper.x >= box.upper.x &&
                          b.upper.y >= box.upper.y && b.upper.z >= box.upper.z;
               });
    };
    const auto binding_foreseen = [&](std::uint32_t slot) {
        return boxes_.contains(scene.objects()[slot].path);
    };
    const auto material_foreseen = [&](std::uint32_t slot) {
        return materials_.contains(scene.materials()[slot].name);
    };
    const bool lights_stay =
        std::equal(old_lights.begin(), old_lights.end(), scene.lights().begin(),
                   scene.lights().end(), [](const LightSlot& a, const LightSlot& b) {
                       return a.path == b.path && same_but_energy(a.record, b.record);
                   });
    return std::all_of(applied.geometry.begin(), applied.geometry.end(), foreseen) &&
           std::all_of(applied.rebound.begin(), applied.rebound.end(), binding_foreseen) &&
           std::all_of(applied.materials.begin(), applied.materials.end(), material_foreseen) &&
           (lights_move_ || lights_stay);
}

}  // namespace irt
