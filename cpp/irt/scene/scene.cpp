// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/scene.h"

#include <murmurhash.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>
#include <utility>

#include "irt/math/bits.h"
#include "irt/scene/compile.h"
#include "irt/scene/equality.h"

namespace irt {

namespace {

M44d relative_to(const M44d& world_from_object, const V3d& origin) {
    M44d m = world_from_object;
    for (int a = 0; a < 3; ++a) m[3][a] -= origin[a];
    return m;
}

bool is_instance(const Object& object) {
    return std::holds_alternative<std::shared_ptr<const Prototype>>(object.geometry);
}

bool is_array(const Object& object) {
    return std::holds_alternative<std::shared_ptr<const InstanceArray>>(object.geometry);
}

std::string entry_name(const std::string& path, std::int64_t key) {
    return path + "[" + std::to_string(key) + "]";
}

/// Whether an entry of two arrays is the same instance in the same place.
bool same_entry(const ObjectSlot& a, std::size_t i, const ObjectSlot& b, std::size_t j) {
    return &a.prototype_of(i) == &b.prototype_of(j) &&
           same_bits(a.array->array_from_prototype[i], b.array->array_from_prototype[j]);
}

const Mesh* mesh_of(const Object& object) {
    const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&object.geometry);
    return mesh ? mesh->get() : nullptr;
}

/// Whether rays meet the two alike: only shading may differ.
bool same_hits(const Object& a, const Object& b) {
    if (!same_bits(a.world_from_object, b.world_from_object)) return false;
    if (a.role.camera_visible != b.role.camera_visible) return false;
    // What is instanced has no points of its own that could be told to shade otherwise.
    if ((is_instance(a) || is_array(a)) && a.role != b.role) return false;
    const Mesh *mesh = mesh_of(a), *other = mesh_of(b);
    return mesh && other ? mesh == other || same_hits(*mesh, *other) : same(a.geometry, b.geometry);
}

/// Of two that rays meet alike. Of what is instanced the parts name their own materials.
bool same_shading(const Object& a, const Object& b) {
    return is_instance(a) || is_array(a) ||
           (same(a.geometry, b.geometry) && same(a.primvars, b.primvars) &&
            a.material == b.material && a.face_materials == b.face_materials && a.role == b.role);
}

/// The materials that `object` may show, part by part.
std::vector<Material> shown(const ObjectSlot& object, const std::vector<MaterialSlot>& materials) {
    std::vector<Material> records;
    for (const std::uint32_t material : materials_of(object))
        records.push_back(materials[material].record);
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

std::vector<std::uint32_t> materials_of(const ObjectSlot& object) {
    if (object.prototype) return object.prototype->materials;
    std::vector<std::uint32_t> slots;
    if (!object.array) add_materials(object.surface, slots);
    for (const auto& prototype : object.prototypes)
        slots.insert(slots.end(), prototype->materials.begin(), prototype->materials.end());
    return slots;
}

/// A change set made ready: all that can be refused has been.
struct Scene::Prepared {
    SlotOf material_slots;                                      ///< as they will be
    std::set<std::string> materials;                            ///< those that will be live
    std::vector<ObjectSlot> objects;                            ///< added, moved or reshaped
    std::vector<std::pair<std::uint32_t, ObjectSlot>> rebound;  ///< those that shade otherwise
    std::vector<std::uint32_t> removed;                         ///< objects
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

std::uint32_t path_hash(const std::string& path) {
    std::uint32_t hash[1];
    lmmh_x86_32(path.data(), static_cast<unsigned>(path.size()), 0, hash);
    return hash[0];
}

Scene::Scene(const V3d& render_origin) : render_origin_(render_origin) {}

ObjectSlot Scene::compile(const std::string& path, const Object& record, Prepared& prepared) const {
    const MaterialIndex material = prepared.materials_for(path);
    check_constant(record.primvars, path);
    const PrototypeCompiler compiled = [&](const std::shared_ptr<const Prototype>& source,
                                           const std::string& part_path) {
        const auto known = prototypes_.find(source);
        if (known != prototypes_.end())
            if (auto made = known->second.lock()) return made;
        auto& made = prepared.prototypes[source];
        if (!made) made = compile_prototype(*source, material, compiled, part_path);
        return made;
    };
    ObjectSlot slot;
    slot.live = true;
    slot.path = path;
    slot.id = path_hash(path);
    slot.record = record;
    const M44d render_from_object = relative_to(record.world_from_object, render_origin_);
    if (is_instance(record)) {
        slot.render_from_prototype = render_from_object;
        slot.prototype_from_render = checked_inverse(render_from_object, path);
        slot.prototype =
            compiled(std::get<std::shared_ptr<const Prototype>>(record.geometry), path);
    } else if (is_array(record)) {
        slot.array = std::get<std::shared_ptr<const InstanceArray>>(record.geometry);
        slot.render_from_array = render_from_object;
        compile_array(find(path, true), compiled, slot);
    } else {
        slot.surface =
            compile_surface(record.geometry, render_from_object, material(record.material),
                            slots_of(record.face_materials, material), path);
        slot.surface.primvars = record.primvars;
    }
    return slot;
}

/// `old` as `record`, which rays meet alike, has it shaded.
ObjectSlot Scene::rebind(const ObjectSlot& old, const Object& record, Prepared& prepared) const {
    if (!same(old.record.geometry, record.geometry)) {
        ObjectSlot slot = compile(old.path, record, prepared);
        slot.rank = old.rank;
        slot.slot = old.slot;
        return slot;
    }
    check_constant(record.primvars, old.path);
    ObjectSlot slot = old;
    slot.record = record;
    slot.record.geometry = old.record.geometry;
    const MaterialIndex material = prepared.materials_for(old.path);
    slot.surface.material = material(record.material);
    slot.surface.face_materials = slots_of(record.face_materials, material);
    check_face_materials(slot.surface, old.path);
    slot.surface.primvars = record.primvars;
    return slot;
}

/// Fills in the prototypes of `slot`; `old`: the array of the same path, or null.
void Scene::compile_array(const ObjectSlot* old, const PrototypeCompiler& compiled,
                          ObjectSlot& slot) const {
    const InstanceArray& array = *slot.array;
    check_array(array, slot.path);
    if (array.size() >= trace::none - slots_.size())
        throw std::invalid_argument(slot.path + ": more instances than 32 bits can number");
    // A prototype made again with the same contents is the same: what it was compiled to stays.
    for (const auto& prototype : array.prototypes) {
        std::shared_ptr<const CompiledPrototype> made;
        for (std::size_t i = 0; old && !made && i < old->prototypes.size(); ++i) {
            const auto& before = old->array->prototypes[i];
            if (before == prototype || same(*before, *prototype)) made = old->prototypes[i];
        }
        slot.prototypes.push_back(made ? made : compiled(prototype, slot.path));
    }
    // What stands as it stood was checked before.
    const bool stays = old && old->live && old->array->size() == array.size() &&
                       same_bits(old->render_from_array, slot.render_from_array);
    for (std::size_t entry = 0; entry < array.size(); ++entry)
        if (!stays ||
            !same_bits(old->array->array_from_prototype[entry], array.array_from_prototype[entry]))
            (void)checked_inverse(slot.render_from_entry(entry),
                                  entry_name(slot.path, array.key(entry)));
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
        for (const std::uint32_t material : materials_of(object))
            if (removed_materials.contains(material))
                throw std::invalid_argument(object.path + ": its material was removed");
    };

    for (const auto& [path, record] : changes.objects) {
        // A path may have had an array and an object that is none, one after the other.
        for (const bool array : {false, true}) {
            const ObjectSlot* old = find(path, array);
            if (old && old->live && !(record && is_array(*record) == array))
                prepared.removed.push_back(index_of(*old));
        }
        if (!record) continue;
        const ObjectSlot* old = find(path, is_array(*record));
        if (!old || !old->live || !same_hits(old->record, *record)) {
            prepared.objects.push_back(compile(path, *record, prepared));
            if (!removed_materials.empty()) require_materials(prepared.objects.back());
        } else if (!same_shading(old->record, *record)) {
            prepared.rebound.emplace_back(index_of(*old), rebind(*old, *record, prepared));
            if (!removed_materials.empty()) require_materials(prepared.rebound.back().second);
        } else if (!removed_materials.empty()) {
            require_materials(*old);
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
        slot = {
            true,           name, *record, tint_varies(*record), {}, false, shadow_depth(*record),
            path_hash(name)};
        if (slot.tint_varies) {
            slot.tint_nodes = nodes_behind(*record, {tint_inputs.begin(), tint_inputs.end()});
            slot.tint_reads_place = reads_place(*record, slot.tint_nodes);
        }
        applied.materials.push_back(found->second);
    }

    for (const auto& [source, compiled] : prepared.prototypes) prototypes_[source] = compiled;
    for (const std::uint32_t index : prepared.removed) {
        ObjectSlot empty;
        empty.path = objects_[index].path;
        if (objects_[index].array) {
            empty.array = std::make_shared<const InstanceArray>();
            place_entries(index, std::move(empty), applied);
        } else {
            replace(index, std::move(empty), applied);
        }
    }
    for (ObjectSlot& next : prepared.objects) {
        const bool array = next.array != nullptr;
        const std::uint32_t index = find_or_add(next.path, array);
        if (array)
            place_entries(index, std::move(next), applied);
        else
            replace(index, std::move(next), applied);
    }
    for (std::size_t i = 0; i < prepared.rebound.size(); ++i) {
        auto& [index, slot] = prepared.rebound[i];
        ObjectSlot& object = objects_[index];
        for (const std::uint32_t material : materials_of(object))
            applied.unbound.push_back(material);
        const bool repainted = !same(object.record.geometry, slot.record.geometry) ||
                               !same(object.record.primvars, slot.record.primvars);
        object = std::move(slot);
        applied.rebound.push_back(object.slot);
        if (tints_otherwise(materials_before[i], shown(object, materials_), repainted))
            applied.retinted.push_back(object.slot);
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

const ObjectSlot* Scene::find(const std::string& path, bool array) const {
    const auto found = object_indices_.find({path, array});
    return found == object_indices_.end() ? nullptr : &objects_[found->second];
}

std::uint32_t Scene::index_of(const ObjectSlot& object) const {
    return static_cast<std::uint32_t>(&object - objects_.data());
}

std::uint32_t Scene::find_or_add(const std::string& path, bool array) {
    const auto next = static_cast<std::uint32_t>(objects_.size());
    const auto [found, added] = object_indices_.try_emplace({path, array}, next);
    if (!added) return found->second;
    ObjectSlot& object = objects_.emplace_back();
    object.path = path;
    if (!array) {
        object.slot = slot_count();
        slots_.push_back({next, 0});
        return next;
    }
    object.array = std::make_shared<const InstanceArray>();
    return next;
}

/// Puts `next` in the place of an object that is no array.
void Scene::replace(std::uint32_t index, ObjectSlot next, AppliedChanges& applied) {
    ObjectSlot& object = objects_[index];
    next.rank = object.rank;
    next.slot = object.slot;
    std::swap(object, next);
    if (next.live) applied.previous.push_back(std::move(next));
    applied.geometry.push_back(object.slot);
}

/// Puts `next` in the place of an array, and finds which entries differ.
void Scene::place_entries(std::uint32_t index, ObjectSlot next, AppliedChanges& applied) {
    std::vector<KeyRun>& runs = key_runs_[index];
    add_keys(runs, *next.array, index);
    FormerEntries former;
    next.rank = objects_[index].rank;
    former.array = std::exchange(objects_[index], std::move(next));
    const ObjectSlot &now = objects_[index], &was = former.array;
    const bool moved = !same_bits(now.render_from_array, was.render_from_array) ||
                       now.record.role != was.record.role;
    if (now.prototypes != was.prototypes) applied.renumbered.push_back(index);
    bool repainted = false;
    std::size_t i = 0, j = 0;  // entries of the array that was and of that which is
    auto run = runs.begin();
    while (i < was.array->size() || j < now.array->size()) {
        const bool old = i < was.array->size() &&
                         (j == now.array->size() || was.array->key(i) <= now.array->key(j));
        const bool fresh = j < now.array->size() &&
                           (i == was.array->size() || now.array->key(j) <= was.array->key(i));
        const std::int64_t key = old ? was.array->key(i) : now.array->key(j);
        while (run->key + run->count <= key) ++run;
        const std::uint32_t slot = run->slot + static_cast<std::uint32_t>(key - run->key);
        slots_[slot].entry = fresh ? static_cast<std::uint32_t>(j) : trace::none;
        if (!(old && fresh) || moved || !same_entry(was, i, now, j)) {
            applied.geometry.push_back(slot);
            if (old) former.entries.push_back(static_cast<std::uint32_t>(i));
        } else if (!same_primvars(*was.array, i, *now.array, j)) {
            applied.rebound.push_back(slot);
            repainted = true;
            if (tints_vary(now.prototype_of(j))) applied.retinted.push_back(slot);
        }
        i += old ? 1 : 0;
        j += fresh ? 1 : 0;
    }
    if (repainted)
        for (const std::uint32_t material : materials_of(now)) applied.unbound.push_back(material);
    if (!former.entries.empty()) applied.former.push_back(std::move(former));
}

/// Whether primvars may change how a prototype tints shadows.
bool Scene::tints_vary(const CompiledPrototype& prototype) const {
    return std::any_of(prototype.materials.begin(), prototype.materials.end(),
                       [&](std::uint32_t material) { return materials_[material].tint_varies; });
}

/// Gives slots to those keys of `array` that have none yet.
void Scene::add_keys(std::vector<KeyRun>& runs, const InstanceArray& array, std::uint32_t index) {
    std::vector<KeyRun> added;
    std::size_t known = 0;
    for (std::size_t entry = 0; entry < array.size(); ++entry) {
        const std::int64_t key = array.key(entry);
        while (known < runs.size() && runs[known].key + runs[known].count <= key) ++known;
        if (known < runs.size() && runs[known].key <= key) continue;
        if (added.empty() || added.back().key + added.back().count != key)
            added.push_back({key, slot_count(), 0});
        ++added.back().count;
        slots_.push_back({index, trace::none});
    }
    if (added.empty()) return;
    std::vector<KeyRun> all;
    std::merge(runs.begin(), runs.end(), added.begin(), added.end(), std::back_inserter(all),
               [](const KeyRun& a, const KeyRun& b) { return a.key < b.key; });
    runs.clear();
    for (const KeyRun& run : all)
        if (!runs.empty() && runs.back().key + runs.back().count == run.key &&
            runs.back().slot + runs.back().count == run.slot)
            runs.back().count += run.count;
        else
            runs.push_back(run);
}

std::vector<std::uint32_t> Scene::entry_slots(const ObjectSlot& array) const {
    std::vector<std::uint32_t> slots;
    if (array.array->size() == 0) return slots;
    slots.reserve(array.array->size());
    auto run = key_runs_.at(index_of(array)).begin();
    for (std::size_t entry = 0; entry < array.array->size(); ++entry) {
        const std::int64_t key = array.array->key(entry);
        while (run->key + run->count <= key) ++run;
        slots.push_back(run->slot + static_cast<std::uint32_t>(key - run->key));
    }
    return slots;
}

M44d Scene::render_from_trace(std::uint32_t slot, std::uint32_t part) const {
    const CompiledPrototype* shared = prototype(slot);
    if (!shared) return {};
    M44d m = render_from_prototype(slot);
    (void)shared->part(part, [&](const NestedArray& array, std::uint32_t entry) {
        m = array.outer_from_prototype(entry) * m;
    });
    return m;
}

bool Scene::matte(std::uint32_t slot, std::uint32_t part) const {
    if (object(slot).record.role.matte) return true;
    const CompiledPrototype* shared = prototype(slot);
    if (!shared || !shared->mattes) return false;
    bool within = false;
    const Surface& surface =
        shared->part(part, [&](const NestedArray& array, std::uint32_t /*entry*/) {
            within = within || array.role.matte;
        });
    return within || surface.role.matte;
}

std::string Scene::name(std::uint32_t slot) const {
    const ObjectSlot& o = object(slot);
    return o.array ? entry_name(o.path, o.array->key(entry(slot))) : o.path;
}

std::uint32_t Scene::id(std::uint32_t slot) const {
    const ObjectSlot& o = object(slot);
    return o.array ? path_hash(name(slot)) : o.id;
}

/// Ranks only need to order live objects by path, so all paths ever seen are ranked together.
void Scene::rank_objects() {
    std::uint32_t rank = 0;
    for (const auto& [key, index] : object_indices_) objects_[index].rank = rank++;
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
        slot.unlit = named(light.unlit);
        const bool fades = light.shadow_distance >= 0 && light.shadow_falloff > 0;
        if (fades || !light.shadowless.empty()) {
            trace::ShadowRule& rule = slot.shadow_rule.emplace();
            rule.shadowless = named(light.shadowless);
            rule.distance = static_cast<double>(light.shadow_distance);
            if (fades)
                rule.falloff = std::min(static_cast<double>(light.shadow_falloff), rule.distance);
            rule.gamma = static_cast<double>(light.shadow_falloff_gamma);
        }
        lights_.push_back(std::move(slot));
    }
}

/// By index into all_objects(): those of `paths`. It ends with the last of them.
std::vector<bool> Scene::named(const std::vector<std::string>& paths) const {
    std::vector<bool> objects;
    for (const std::string& path : paths)
        for (const bool array : {false, true}) {
            const auto found = object_indices_.find({path, array});
            if (found == object_indices_.end()) continue;
            if (objects.size() <= found->second) objects.resize(found->second + 1);
            objects[found->second] = true;
        }
    return objects;
}

}  // namespace irt
