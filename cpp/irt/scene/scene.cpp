// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/scene.h"

#include <murmurhash.h>

#include <set>
#include <stdexcept>

#include "irt/math/bits.h"
#include "irt/scene/compile.h"
#include "irt/scene/equality.h"

namespace irt {

namespace {

std::uint32_t path_hash(const std::string& path) {
    std::uint32_t hash[1];
    lmmh_x86_32(path.data(), static_cast<unsigned>(path.size()), 0, hash);
    return hash[0];
}

M44d relative_to(const M44d& world_from_object, const V3d& origin) {
    M44d m = world_from_object;
    for (int a = 0; a < 3; ++a) m[3][a] -= origin[a];
    return m;
}

bool is_instance(const Object& object) {
    return std::holds_alternative<std::shared_ptr<const Prototype>>(object.geometry);
}

const Mesh* mesh_of(const Object& object) {
    const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&object.geometry);
    return mesh ? mesh->get() : nullptr;
}

/// Whether rays meet the two alike: only shading may differ.
bool same_hits(const Object& a, const Object& b) {
    if (!same_bits(a.world_from_object, b.world_from_object)) return false;
    const Mesh *mesh = mesh_of(a), *other = mesh_of(b);
    return mesh && other ? mesh == other || same_hits(*mesh, *other) : same(a.geometry, b.geometry);
}

/// Of two that rays meet alike. An instance's parts name their own materials.
bool same_shading(const Object& a, const Object& b) {
    return same(a.geometry, b.geometry) && same(a.primvars, b.primvars) &&
           (is_instance(a) || (a.material == b.material && a.face_materials == b.face_materials));
}

/// The materials that `object` may show, part by part.
std::vector<Material> shown(const ObjectSlot& object, const std::vector<MaterialSlot>& materials) {
    std::vector<Material> records;
    (void)object.any_material([&](std::uint32_t material) {
        records.push_back(materials[material].record);
        return false;
    });
    return records;
}

/// Whether an object that showed `before` and now shows `after` may tint shadows otherwise;
/// `repainted`: its faces or primvars say otherwise which and how.
bool tints_otherwise(const std::vector<Material>& before, const std::vector<Material>& after,
                     bool repainted) {
    if (!std::equal(before.begin(), before.end(), after.begin(), after.end(), same_tint))
        return true;
    return repainted && std::any_of(after.begin(), after.end(), [&](const Material& material) {
               return tint_varies(material) || !same_tint(material, after.front());
           });
}

}  // namespace

/// A change set made ready: all that can be refused has been.
struct Scene::Prepared {
    SlotOf material_slots;                                      ///< as they will be
    std::set<std::string> materials;                            ///< those that will be live
    std::vector<std::pair<std::string, ObjectSlot>> objects;    ///< added, moved or reshaped
    std::vector<std::pair<std::uint32_t, ObjectSlot>> rebound;  ///< those that shade otherwise
    std::vector<std::uint32_t> removed;
    std::map<std::shared_ptr<const Prototype>, std::shared_ptr<const CompiledPrototype>> prototypes;

    /// Slots of the materials of the object `path`; it throws std::invalid_argument where there is
    /// none of a name.
    [[nodiscard]] MaterialIndex materials_for(const std::string& path) const {
        return [this, path](const std::string& name) {
            if (!materials.contains(name))
                throw std::invalid_argument(path + ": no material named '" + name + "'");
            return material_slots.at(name);
        };
    }
};

Scene::Scene(const V3d& render_origin) : render_origin_(render_origin) {}

ObjectSlot Scene::compile(const std::string& path, const Object& record, Prepared& prepared) const {
    const MaterialIndex material = prepared.materials_for(path);
    check_constant(record.primvars, path);
    const M44d render_from_object = relative_to(record.world_from_object, render_origin_);
    ObjectSlot slot;
    slot.live = true;
    slot.path = path;
    slot.id = path_hash(path);
    slot.record = record;
    if (!is_instance(record)) {
        slot.surface =
            compile_surface(record.geometry, render_from_object, material(record.material),
                            slots_of(record.face_materials, material), path);
        return slot;
    }
    slot.render_from_prototype = render_from_object;
    slot.prototype_from_render = checked_inverse(render_from_object, path);
    const auto& source = std::get<std::shared_ptr<const Prototype>>(record.geometry);
    const auto known = prototypes_.find(source);
    if (known != prototypes_.end()) slot.prototype = known->second.lock();
    if (!slot.prototype) {
        auto& compiled = prepared.prototypes[source];
        if (!compiled) compiled = compile_prototype(*source, material, path);
        slot.prototype = compiled;
    }
    return slot;
}

/// `old` as `record`, which rays meet alike, has it shaded.
ObjectSlot Scene::rebind(const ObjectSlot& old, const Object& record, Prepared& prepared) const {
    if (!same(old.record.geometry, record.geometry)) {
        ObjectSlot slot = compile(old.path, record, prepared);
        slot.rank = old.rank;
        return slot;
    }
    check_constant(record.primvars, old.path);
    ObjectSlot slot = old;
    slot.record = record;
    slot.record.geometry = old.record.geometry;
    if (is_instance(record)) return slot;
    const MaterialIndex material = prepared.materials_for(old.path);
    slot.surface.material = material(record.material);
    slot.surface.face_materials = slots_of(record.face_materials, material);
    check_face_materials(slot.surface, old.path);
    return slot;
}

Scene::Prepared Scene::prepare(const ChangeSet& changes) const {
    Prepared prepared;
    prepared.material_slots = material_slots_;
    for (const MaterialSlot& material : materials_)
        if (material.live) prepared.materials.insert(material.name);
    std::set<std::uint32_t> removed_materials;
    for (const auto& [name, record] : changes.materials) {
        const auto next = static_cast<std::uint32_t>(prepared.material_slots.size());
        const auto found = prepared.material_slots.find(name);
        if (record) {
            check(*record, name);
            prepared.material_slots.try_emplace(name, next);
            prepared.materials.insert(name);
        } else if (found != prepared.material_slots.end()) {
            removed_materials.insert(found->second);
            prepared.materials.erase(name);
        }
    }
    const auto require_materials = [&](const ObjectSlot& object) {
        if (object.any_material([&](std::uint32_t m) { return removed_materials.contains(m); }))
            throw std::invalid_argument(object.path + ": its material was removed");
    };

    for (const auto& [path, record] : changes.objects) {
        const auto found = object_slots_.find(path);
        const bool live = found != object_slots_.end() && objects_[found->second].live;
        if (!record) {
            if (live) prepared.removed.push_back(found->second);
        } else if (!live || !same_hits(objects_[found->second].record, *record)) {
            prepared.objects.emplace_back(path, compile(path, *record, prepared));
            if (!removed_materials.empty()) require_materials(prepared.objects.back().second);
        } else if (!same_shading(objects_[found->second].record, *record)) {
            prepared.rebound.emplace_back(found->second,
                                          rebind(objects_[found->second], *record, prepared));
            if (!removed_materials.empty()) require_materials(prepared.rebound.back().second);
        } else if (!removed_materials.empty()) {
            require_materials(objects_[found->second]);
        }
    }

    if (!removed_materials.empty())
        for (const ObjectSlot& object : objects_)
            if (object.live && !changes.objects.contains(object.path)) require_materials(object);
    return prepared;
}

AppliedChanges Scene::apply(const ChangeSet& changes) {
    Prepared prepared = prepare(changes);
    AppliedChanges applied;

    std::vector<std::vector<Material>> materials_before;  // of what is rebound
    for (const auto& [index, slot] : prepared.rebound)
        materials_before.push_back(shown(objects_[index], materials_));

    material_slots_ = std::move(prepared.material_slots);
    materials_.resize(material_slots_.size());
    for (const auto& [name, record] : changes.materials) {
        const auto found = material_slots_.find(name);
        if (found == material_slots_.end()) continue;  // removed, and never there
        MaterialSlot& slot = materials_[found->second];
        if (!record) {
            slot.live = false;
            continue;
        }
        if (slot.live && same(slot.record, *record)) continue;
        // What shows a material that is new is itself new or bound to it now.
        if (slot.live && !same_tint(slot.record, *record)) applied.tints.push_back(found->second);
        slot = {true, name, *record, tint_varies(*record), {}, shadow_depth(*record)};
        if (slot.tint_varies)
            slot.tint_nodes = nodes_behind(*record, {tint_inputs.begin(), tint_inputs.end()});
        applied.materials.push_back(found->second);
    }

    for (auto& [path, slot] : prepared.objects) {
        const auto [found, added] =
            object_slots_.try_emplace(path, static_cast<std::uint32_t>(objects_.size()));
        if (added) objects_.emplace_back();
        if (slot.prototype)
            prototypes_[std::get<std::shared_ptr<const Prototype>>(slot.record.geometry)] =
                slot.prototype;
        slot.rank = objects_[found->second].rank;
        std::swap(objects_[found->second], slot);
        if (slot.live) applied.previous.push_back(std::move(slot));
        applied.geometry.push_back(found->second);
    }
    for (const std::uint32_t index : prepared.removed) {
        ObjectSlot empty;
        empty.path = objects_[index].path;
        std::swap(objects_[index], empty);
        applied.previous.push_back(std::move(empty));
        applied.geometry.push_back(index);
    }
    for (std::size_t i = 0; i < prepared.rebound.size(); ++i) {
        auto& [index, slot] = prepared.rebound[i];
        ObjectSlot& object = objects_[index];
        (void)object.any_material([&](std::uint32_t material) {
            applied.unbound.push_back(material);
            return false;
        });
        const bool repainted = !same(object.record.geometry, slot.record.geometry) ||
                               !same(object.record.primvars, slot.record.primvars);
        object = std::move(slot);
        applied.rebound.push_back(index);
        if (tints_otherwise(materials_before[i], shown(object, materials_), repainted))
            applied.retinted.push_back(index);
    }
    if (!prepared.objects.empty()) rank_objects();
    std::erase_if(prototypes_, [](const auto& entry) { return entry.second.expired(); });

    for (const auto& [path, record] : changes.lights) {
        const auto found = light_records_.find(path);
        const bool known = found != light_records_.end();
        if (record ? known && same(found->second, *record) : !known) continue;
        if (record)
            light_records_[path] = *record;
        else
            light_records_.erase(found);
        applied.lights.push_back(path);
    }
    if (!applied.lights.empty() || !prepared.objects.empty()) order_lights();

    if (!applied.empty()) ++version_;
    return applied;
}

/// Ranks only need to order live objects by path, so all paths ever seen are ranked together.
void Scene::rank_objects() {
    std::uint32_t rank = 0;
    for (const auto& [path, index] : object_slots_) objects_[index].rank = rank++;
}

void Scene::order_lights() {
    lights_.clear();
    for (const auto& [path, light] : light_records_) {
        if (light.energy == V3f(0, 0, 0)) continue;
        LightSlot slot;
        slot.path = path;
        slot.id = path_hash(path);
        slot.record = light;
        slot.position_render = light.position - render_origin_;
        slot.shaped = light.profile != Profile::Uniform || light.cone_angle < 180 ||
                      light.focus > 0 || light.ies;
        for (const std::string& object : light.unlit) {
            const auto found = object_slots_.find(object);
            if (found == object_slots_.end()) continue;
            if (slot.unlit.size() <= found->second) slot.unlit.resize(found->second + 1);
            slot.unlit[found->second] = true;
        }
        lights_.push_back(std::move(slot));
    }
}

}  // namespace irt
