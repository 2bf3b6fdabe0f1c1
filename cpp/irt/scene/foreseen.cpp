// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/foreseen.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "irt/math/bits.h"
#include "irt/scene/equality.h"
#include "irt/trace/judge_many.h"

namespace irt {

namespace {

/// Boxes an object may have before they become one.
constexpr std::size_t most_boxes = 64;

const InstanceArray* array_of(const Object& object) {
    const auto* array = std::get_if<std::shared_ptr<const InstanceArray>>(&object.geometry);
    return array ? array->get() : nullptr;
}

bool lit(const Light& light) { return light.energy != V3f(0, 0, 0); }

}  // namespace

Foreseen::Foreseen(const ChangeSet& initial) {
    for (const auto& [path, record] : initial.lights)
        if (record) lights_.emplace(path, *record);
    for (const auto& [path, record] : initial.objects)
        if (record && array_of(*record)) arrays_[path].last = *record;
}

trace::Box Foreseen::world_box(const Object& object) const {
    trace::Box box;
    const M44d& m = object.world_from_object;
    if (const auto* quadric = std::get_if<Quadric>(&object.geometry)) {
        const V3d centre = transform_point(m, V3d(0));
        const V3d half = trace::quadric_half_extent(*quadric, m);
        box.extend(centre - half);
        box.extend(centre + half);
    } else if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&object.geometry)) {
        for (const V3f& p : (*mesh)->points) box.extend(transform_point(m, V3d(p)));
    } else if (const auto* spheres =
                   std::get_if<std::shared_ptr<const Spheres>>(&object.geometry)) {
        for (const Ball& ball : (*spheres)->balls) box.extend(trace::ball_box(ball, m));
    } else if (const auto* curves = std::get_if<std::shared_ptr<const Curves>>(&object.geometry)) {
        for (const Ball& ball : (*curves)->balls) box.extend(trace::ball_box(ball, m));
    } else if (const auto* prototype =
                   std::get_if<std::shared_ptr<const Prototype>>(&object.geometry)) {
        const trace::Box own = box_of(*prototype);
        if (!own.empty()) box = trace::transformed(own, m);
    } else {
        for (std::size_t entry = 0; entry < array_of(object)->size(); ++entry)
            if (const trace::Box own = entry_box(object, entry); !own.empty()) box.extend(own);
    }
    return box;
}

trace::Box Foreseen::entry_box(const Object& object, std::size_t entry) const {
    const InstanceArray& array = *array_of(object);
    const trace::Box own = box_of(array.prototypes[array.prototype(entry)]);
    if (own.empty()) return own;
    return trace::transformed(own,
                              placed(array.array_from_prototype[entry], object.world_from_object));
}

trace::Box Foreseen::box_of(const std::shared_ptr<const Prototype>& prototype) const {
    const auto known = prototype_boxes_.find(prototype);
    if (known != prototype_boxes_.end()) return known->second;
    trace::Box box;
    for (const Part& part : prototype->parts)
        if (const trace::Box own =
                world_box({part.geometry, part.prototype_from_part, part.material});
            !own.empty())
            box.extend(own);
    std::erase_if(prototype_boxes_, [](const auto& entry) { return entry.first.expired(); });
    prototype_boxes_.emplace(prototype, box);
    return box;
}

void Foreseen::add_box(const std::string& path, const trace::Box& box) {
    std::vector<trace::Box>& boxes = boxes_[path];
    if (!box.empty()) boxes.push_back(box);
    if (boxes.size() <= most_boxes) return;
    for (const trace::Box& other : boxes) boxes.front().extend(other);
    boxes.resize(1);
}

/// Of an array only the entries that change.
void Foreseen::add_array(const std::string& path, Object now) {
    Array& known = arrays_[path];
    if (!array_of(known.last)) known.last.geometry = std::make_shared<const InstanceArray>();
    const InstanceArray &was = *array_of(known.last), &is = *array_of(now);
    const bool moved = !same_bits(known.last.world_from_object, now.world_from_object) ||
                       known.last.role != now.role;
    std::vector<std::int64_t> keys;
    std::size_t i = 0, j = 0;
    while (i < was.size() || j < is.size()) {
        const bool old = i < was.size() && (j == is.size() || was.key(i) <= is.key(j));
        const bool fresh = j < is.size() && (i == was.size() || is.key(j) <= was.key(i));
        const auto same_prototype = [&] {
            const auto &p = was.prototypes[was.prototype(i)], &q = is.prototypes[is.prototype(j)];
            return p == q || same(*p, *q);
        };
        if (!(old && fresh) || moved ||
            !same_bits(was.array_from_prototype[i], is.array_from_prototype[j]) ||
            !same_primvars(was, i, is, j) || !same_prototype()) {
            keys.push_back(old ? was.key(i) : is.key(j));
            if (fresh) add_box(path, entry_box(now, j));
        }
        i += old ? 1 : 0;
        j += fresh ? 1 : 0;
    }
    std::vector<std::int64_t> all;
    std::set_union(known.keys.begin(), known.keys.end(), keys.begin(), keys.end(),
                   std::back_inserter(all));
    known.keys = std::move(all);
    known.last = std::move(now);
}

void Foreseen::add(const ChangeSet& changes) {
    for (const auto& [path, record] : changes.objects) {
        if (record && array_of(*record)) {
            boxes_.try_emplace(path);  // an object that is none may have made room for it
            add_array(path, *record);
            continue;
        }
        if (arrays_.contains(path))
            add_array(path, {std::make_shared<const InstanceArray>(), {}, {}});
        add_box(path, record ? world_box(*record) : trace::Box());
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

bool Foreseen::entry_changes(const std::string& path, std::int64_t key) const {
    const auto found = arrays_.find(path);
    return found != arrays_.end() &&
           std::binary_search(found->second.keys.begin(), found->second.keys.end(), key);
}

bool Foreseen::object_changes(const Scene& scene, std::uint32_t slot) const {
    const ObjectSlot& object = scene.object(slot);
    return object.array ? entry_changes(object.path, object.array->key(scene.entry(slot)))
                        : boxes_.contains(object.path);
}

/// Whether `box` lies in one of those that were foreseen.
bool Foreseen::within(const std::string& path, const trace::Box& box) const {
    const auto found = boxes_.find(path);
    return box.empty() ||
           (found != boxes_.end() &&
            std::any_of(found->second.begin(), found->second.end(), [&](const trace::Box& b) {
                return b.lower.x <= box.lower.x && b.lower.y <= box.lower.y &&
                       b.lower.z <= box.lower.z && b.upper.x >= box.upper.x &&
                       b.upper.y >= box.upper.y && b.upper.z >= box.upper.z;
            }));
}

bool Foreseen::covers(const Scene& scene, const AppliedChanges& applied,
                      const std::vector<LightSlot>& old_lights) const {
    const auto foreseen = [&](std::uint32_t slot) {
        const ObjectSlot& object = scene.object(slot);
        if (!object.array)
            return boxes_.contains(object.path) &&
                   (!object.live || within(object.path, world_box(object.record)));
        // Entries that are gone are among the former ones, below.
        return !scene.live(slot) ||
               (object_changes(scene, slot) &&
                within(object.path, entry_box(object.record, scene.entry(slot))));
    };
    const auto former_foreseen = [&](const FormerEntries& former) {
        return std::all_of(former.entries.begin(), former.entries.end(), [&](std::uint32_t entry) {
            return entry_changes(former.array.path, former.array.array->key(entry));
        });
    };
    const auto binding_foreseen = [&](std::uint32_t slot) {
        return boxes_.contains(scene.object(slot).path);
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
           std::all_of(applied.former.begin(), applied.former.end(), former_foreseen) &&
           std::all_of(applied.rebound.begin(), applied.rebound.end(), binding_foreseen) &&
           std::all_of(applied.materials.begin(), applied.materials.end(), material_foreseen) &&
           (lights_move_ || lights_stay);
}

}  // namespace irt
