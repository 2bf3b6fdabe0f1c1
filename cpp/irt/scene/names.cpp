// SPDX-License-Identifier: Apache-2.0
// The numbers of names, taken from one scene to another.
#include <algorithm>
#include <stdexcept>

#include "irt/scene/scene.h"

namespace irt {

namespace {

void append(std::vector<char>& names, const std::string& name) {
    names.insert(names.end(), name.begin(), name.end());
    names.push_back('\0');
}

std::vector<std::string> split(const std::vector<char>& names) {
    std::vector<std::string> parts;
    for (auto begin = names.begin(); begin != names.end();) {
        const auto end = std::find(begin, names.end(), '\0');
        if (end == names.end()) throw std::runtime_error("names: one does not end");
        parts.emplace_back(begin, end);
        begin = end + 1;
    }
    return parts;
}

bool same_keys(const SceneNames::Keys& a, const SceneNames::Keys& b) {
    return a.key == b.key && a.object == b.object && a.slot == b.slot && a.count == b.count;
}

}  // namespace

bool SceneNames::operator==(const SceneNames& other) const {
    return objects == other.objects && arrays == other.arrays && slots == other.slots &&
           std::equal(keys.begin(), keys.end(), other.keys.begin(), other.keys.end(), same_keys) &&
           materials == other.materials;
}

SceneNames Scene::names() const {
    SceneNames names;
    for (const ObjectSlot& object : objects_) {
        append(names.objects, object.path);
        names.arrays.push_back(object.array != nullptr);
    }
    for (const Slot& slot : slots_) names.slots.push_back(slot.object);
    for (const auto& [object, runs] : key_runs_)
        for (const KeyRun& run : runs) names.keys.push_back({run.key, object, run.slot, run.count});
    std::vector<std::string> materials(material_slots_.size());
    for (const auto& [name, slot] : material_slots_) materials[slot] = name;
    for (const std::string& name : materials) append(names.materials, name);
    return names;
}

void Scene::adopt(const SceneNames& names) {
    if (version_ != 0 || !objects_.empty())
        throw std::logic_error("a scene adopts names before all else");
    const std::vector<std::string> paths = split(names.objects);
    if (paths.size() != names.arrays.size())
        throw std::runtime_error("names: paths and kinds differ in number");
    for (std::uint32_t index = 0; index < paths.size(); ++index) {
        const bool array = names.arrays[index] != 0;
        object_indices_[{paths[index], array}] = index;
        ObjectSlot& object = objects_.emplace_back();
        object.path = paths[index];
        if (array) object.array = std::make_shared<const InstanceArray>();
    }
    for (const std::uint32_t index : names.slots) {
        if (index >= objects_.size()) throw std::runtime_error("names: a slot of no object");
        const bool array = objects_[index].array != nullptr;
        if (!array) objects_[index].slot = slot_count();
        slots_.push_back({index, array ? trace::none : 0});
    }
    for (const SceneNames::Keys& keys : names.keys) {
        if (keys.object >= objects_.size() || keys.count > slots_.size() ||
            keys.slot > slots_.size() - keys.count)
            throw std::runtime_error("names: keys of no slot");
        key_runs_[keys.object].push_back({keys.key, keys.slot, keys.count});
    }
    for (const std::string& name : split(names.materials)) {
        material_slots_[name] = static_cast<std::uint32_t>(materials_.size());
        materials_.emplace_back();
    }
    rank_objects();
}

}  // namespace irt
