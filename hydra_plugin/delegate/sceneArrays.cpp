// SPDX-License-Identifier: Apache-2.0
// Point instancers: rprims that are drawn by the same entries make up a prototype.
#include <algorithm>
#include <utility>

#include "delegate/scene.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

bool SameKeys(const std::vector<HdIrtEntry>& a, const std::vector<HdIrtEntry>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const HdIrtEntry& x, const HdIrtEntry& y) { return x.key == y.key; });
}

/// Prototypes of one instancer under way.
struct Group {
    std::vector<HdIrtEntry> entries;
    irt::Prototype prototype;
};

std::shared_ptr<const irt::InstanceArray> ArrayOf(std::vector<Group> groups) {
    struct Entry {
        std::int64_t key;
        std::uint32_t prototype;
        irt::Affine placed;
    };
    auto array = std::make_shared<irt::InstanceArray>();
    std::vector<Entry> entries;
    for (Group& group : groups) {
        const auto prototype = static_cast<std::uint32_t>(array->prototypes.size());
        array->prototypes.push_back(
            std::make_shared<const irt::Prototype>(std::move(group.prototype)));
        for (const HdIrtEntry& entry : group.entries)
            entries.push_back({entry.key, prototype, entry.array_from_prototype});
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.key < b.key; });
    // Keys name entries, each one only.
    entries.erase(std::unique(entries.begin(), entries.end(),
                              [](const Entry& a, const Entry& b) { return a.key == b.key; }),
                  entries.end());
    bool counted = true;
    for (std::size_t i = 0; i < entries.size(); ++i)
        counted = counted && entries[i].key == static_cast<std::int64_t>(i);
    for (const Entry& entry : entries) {
        array->prototype_of.push_back(entry.prototype);
        if (!counted) array->keys.push_back(entry.key);
        array->array_from_prototype.push_back(entry.placed);
    }
    return array;
}

Group& GroupOf(std::vector<Group>& groups, const std::vector<HdIrtEntry>& entries) {
    for (Group& group : groups)
        if (SameKeys(group.entries, entries)) return group;
    groups.push_back({entries, {}});
    return groups.back();
}

}  // namespace

void HdIrtScene::_AddArrays(Records& objects, Own& own) const {
    std::map<std::string, std::vector<Group>> groups;
    for (const auto& [id, shape] : _shapes) {
        if (shape.instancer.empty() || shape.entries.empty() || !_Drawn(shape)) continue;
        const std::string name = id.GetString();
        GroupOf(groups[shape.instancer], shape.entries)
            .prototype.parts.push_back(_PartOf(name, shape, shape.prototype_from_object, own));
    }
    std::map<std::string, const HdIrtInstancerPlace*> places;
    for (const auto& [id, named] : _instancers) places[named.first] = &named.second;
    // Innermost first: a nested instancer is a part of its parent's prototypes.
    std::set<std::string> done;
    for (bool progress = true; progress;) {
        progress = false;
        for (const auto& [name, place] : places) {
            const bool waits = std::any_of(places.begin(), places.end(), [&](const auto& other) {
                return other.second->parent == name && done.count(other.first) == 0;
            });
            if (waits || !done.insert(name).second) continue;
            progress = true;
            const auto found = groups.find(name);
            if (found == groups.end() || !place->visible) continue;
            const auto array = ArrayOf(std::move(found->second));
            if (place->parent.empty()) {
                irt::Object object;
                object.geometry = array;
                object.world_from_object = place->world_from_array;
                objects[name] = std::move(object);
            } else if (!place->entries.empty()) {
                irt::Part part;
                part.name = name;
                part.geometry = array;
                part.prototype_from_part = place->world_from_array;
                GroupOf(groups[place->parent], place->entries)
                    .prototype.parts.push_back(std::move(part));
            }
        }
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
