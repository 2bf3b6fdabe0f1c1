// SPDX-License-Identifier: Apache-2.0
#include "delegate/scene.h"

#include <algorithm>
#include <utility>

#include "delegate/objectId.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Names that are no prims'.
const std::string defaultMaterial = "irt:default", cameraLight = "irt:cameraLight";

std::string OwnMaterial(const std::string& object) { return object + ".primvars:displayColor"; }

}  // namespace

void HdIrtScene::SetShape(const SdfPath& id, HdIrtShape shape) {
    const std::lock_guard lock(_mutex);
    HdIrtShape& old = _shapes[id];
    if (!shape.instancer.empty() || !old.instancer.empty()) _arraysChanged = true;
    if (shape.categories != old.categories) _lightsChanged = true;
    old = std::move(shape);
    _changedShapes.insert(id);
    _Touch();
}

void HdIrtScene::RemoveShape(const SdfPath& id) {
    const std::lock_guard lock(_mutex);
    const auto found = _shapes.find(id);
    if (found == _shapes.end()) return;
    if (!found->second.instancer.empty()) _arraysChanged = true;
    _shapes.erase(found);
    _changedShapes.insert(id);
    _Touch();
}

void HdIrtScene::SetInstancer(const SdfPath& id, const std::string& name,
                              HdIrtInstancerPlace place) {
    const std::lock_guard lock(_mutex);
    _instancers[id] = {name, std::move(place)};
    _arraysChanged = true;
    _Touch();
}

void HdIrtScene::RemoveInstancer(const SdfPath& id) {
    const std::lock_guard lock(_mutex);
    if (_instancers.erase(id) == 0) return;
    _arraysChanged = true;
    _Touch();
}

void HdIrtScene::SetMaterial(const SdfPath& id, const std::string& name, irt::Material material) {
    const std::lock_guard lock(_mutex);
    // What wore another in its place wears it from now on.
    if (_materials.count(id) == 0) _allChanged = true;
    _materials[id] = {name, std::move(material)};
    _changedMaterials.insert(id);
    _Touch();
}

void HdIrtScene::RemoveMaterial(const SdfPath& id) {
    const std::lock_guard lock(_mutex);
    if (_materials.erase(id) == 0) return;
    _allChanged = true;
    _Touch();
}

void HdIrtScene::SetLight(const SdfPath& id, HdIrtLight light) {
    const std::lock_guard lock(_mutex);
    _lights[id] = std::move(light);
    _lightsChanged = true;
    _Touch();
}

void HdIrtScene::RemoveLight(const SdfPath& id) {
    const std::lock_guard lock(_mutex);
    if (_lights.erase(id) == 0) return;
    _lightsChanged = true;
    _Touch();
}

void HdIrtScene::SetRenderTags(const TfTokenVector& tags) {
    const std::lock_guard lock(_mutex);
    std::set<TfToken> wanted(tags.begin(), tags.end());
    if (wanted == _tags) return;
    _tags = std::move(wanted);
    _allChanged = true;
    _Touch();
}

void HdIrtScene::SetCameraLight(const std::optional<irt::Light>& light) {
    const std::lock_guard lock(_mutex);
    const bool moved = light && _cameraLight && (light->direction != _cameraLight->direction);
    if (light.has_value() == _cameraLight.has_value() && !moved) return;
    _cameraLight = light;
    if (!_lights.empty()) return;
    _lightsChanged = true;
    _Touch();
}

std::set<std::string> HdIrtScene::PrimvarsOf(const std::string& material) const {
    const std::lock_guard lock(_mutex);
    std::set<std::string> names;
    for (const auto& [id, known] : _materials) {
        if (known.name != material) continue;
        for (const irt::ShadeNode& node : known.record.nodes)
            if (!node.primvar.empty()) names.insert(node.primvar);
    }
    return names;
}

irt::ChangeSet HdIrtScene::Take(bool all) {
    const std::lock_guard lock(_mutex);
    irt::ChangeSet changes;
    if (all) {
        _toldObjects.clear();
        _toldArrays = {};
        _toldMaterials.clear();
        _toldLights.clear();
        changes.materials[defaultMaterial] = irt::Material{};
    } else if (!_changed) {
        return changes;
    }
    _AssembleMaterials(changes, all);
    _AssembleObjects(changes, all || _allChanged);
    _AssembleLights(changes, all || _allChanged);
    _changedShapes.clear();
    _changedMaterials.clear();
    _changed = _arraysChanged = _lightsChanged = _allChanged = false;
    return changes;
}

void HdIrtScene::_AssembleMaterials(irt::ChangeSet& changes, bool all) {
    const bool every = all || _allChanged;
    std::set<std::string> there;
    for (const auto& [id, material] : _materials) {
        there.insert(material.name);
        if (every || _changedMaterials.count(id) != 0)
            changes.materials[material.name] = material.record;
    }
    for (const std::string& name : _toldMaterials)
        if (there.count(name) == 0) changes.materials[name] = std::nullopt;
    _toldMaterials = std::move(there);
}

bool HdIrtScene::_Drawn(const HdIrtShape& shape) const {
    return shape.visible && (_tags.empty() || _tags.count(shape.render_tag) != 0);
}

std::string HdIrtScene::_Worn(const std::string& name, const HdIrtShape& shape, Own& own) const {
    if (!shape.material.empty() && _toldMaterials.count(shape.material) != 0) return shape.material;
    if (!shape.own) return defaultMaterial;
    const std::string made = OwnMaterial(name);
    own[made] = *shape.own;
    return made;
}

std::vector<std::string> HdIrtScene::_FaceMaterials(const HdIrtShape& shape,
                                                    const std::string& otherwise) const {
    std::vector<std::string> names = shape.face_materials;
    for (std::string& name : names)
        if (_toldMaterials.count(name) == 0) name = otherwise;
    return names;
}

irt::Part HdIrtScene::_PartOf(const std::string& name, const HdIrtShape& shape,
                              const irt::M44d& placed, Own& own) const {
    irt::Part part;
    part.name = name;
    part.geometry = shape.geometry;
    part.prototype_from_part = placed;
    part.material =
        _Worn(shape.placements.empty() ? name : shape.placements.front().name, shape, own);
    part.primvars = shape.primvars;
    part.face_materials = _FaceMaterials(shape, part.material);
    return part;
}

void HdIrtScene::_AddObjects(const HdIrtShape& shape, Records& objects, Own& own) const {
    std::shared_ptr<const irt::Prototype> shared;
    for (const HdIrtPlacement& placement : shape.placements) {
        irt::Object object;
        object.world_from_object = placement.world_from_object;
        if (shape.native) {
            if (!shared) {
                irt::Prototype prototype;
                prototype.parts.push_back(_PartOf("shape", shape, irt::M44d(), own));
                shared = std::make_shared<const irt::Prototype>(std::move(prototype));
            }
            object.geometry = shared;
        } else {
            object.geometry = shape.geometry;
            object.material = _Worn(placement.name, shape, own);
            object.primvars = shape.primvars;
            object.face_materials = _FaceMaterials(shape, object.material);
        }
        objects[placement.name] = std::move(object);
    }
}

void HdIrtScene::_Tell(irt::ChangeSet& changes, Told& told, Records objects, const Own& own) {
    Told now;
    for (auto& [name, object] : objects) {
        now.objects.insert(name);
        changes.objects[name] = std::move(object);
    }
    for (const auto& [name, material] : own) {
        now.materials.insert(name);
        changes.materials[name] = material;
    }
    // Another rprim may have taken the name over in the same change set.
    for (const std::string& name : told.objects)
        if (now.objects.count(name) == 0) changes.objects.try_emplace(name, std::nullopt);
    for (const std::string& name : told.materials)
        if (now.materials.count(name) == 0) changes.materials.try_emplace(name, std::nullopt);
    told = std::move(now);
}

void HdIrtScene::_AssembleObjects(irt::ChangeSet& changes, bool all) {
    if (all) {
        for (const auto& [id, shape] : _shapes) _changedShapes.insert(id);
        for (const auto& [id, told] : _toldObjects) _changedShapes.insert(id);
    }
    // What is gone is told last, so that names that moved on are not taken away.
    std::vector<SdfPath> ids(_changedShapes.begin(), _changedShapes.end());
    std::stable_partition(ids.begin(), ids.end(),
                          [&](const SdfPath& id) { return _shapes.count(id) != 0; });
    for (const SdfPath& id : ids) {
        Records objects;
        Own own;
        const auto found = _shapes.find(id);
        if (found != _shapes.end() && found->second.instancer.empty() && _Drawn(found->second))
            _AddObjects(found->second, objects, own);
        _Tell(changes, _toldObjects[id], std::move(objects), own);
        if (found == _shapes.end()) _toldObjects.erase(id);
    }
    if (!all && !_arraysChanged) return;
    Records arrays;
    Own own;
    _AddArrays(arrays, own);
    _Tell(changes, _toldArrays, std::move(arrays), own);
}

void HdIrtScene::_AssembleLights(irt::ChangeSet& changes, bool all) {
    if (!all && !_lightsChanged) return;
    std::set<std::string> there;
    for (const auto& [id, light] : _lights) {
        std::vector<std::string> unlit;
        if (!light.link.empty()) unlit = _Unlit(light.link);
        for (const auto& [name, record] : light.records) {
            irt::Light linked = record;
            linked.unlit = unlit;
            changes.lights[name] = std::move(linked);
            there.insert(name);
        }
    }
    if (_lights.empty() && _cameraLight) {
        changes.lights[cameraLight] = *_cameraLight;
        there.insert(cameraLight);
    }
    for (const std::string& name : _toldLights)
        if (there.count(name) == 0) changes.lights[name] = std::nullopt;
    _toldLights = std::move(there);
}

std::vector<std::string> HdIrtScene::_Unlit(const std::string& link) const {
    std::set<std::string> unlit;
    for (const auto& [id, shape] : _shapes) {
        if (shape.categories.count(link) != 0) continue;
        for (const HdIrtPlacement& placement : shape.placements) unlit.insert(placement.name);
        if (!shape.instancer.empty()) unlit.insert(shape.instancer);
    }
    return {unlit.begin(), unlit.end()};
}

std::unordered_map<std::uint32_t, HdIrtPick> HdIrtScene::Picks() const {
    const std::lock_guard lock(_mutex);
    std::unordered_map<std::uint32_t, HdIrtPick> picks;
    for (const auto& [id, shape] : _shapes) {
        std::int32_t instance = 0;
        for (const HdIrtPlacement& placement : shape.placements)
            picks[HdIrtObjectId(placement.name)] = {shape.prim_id, instance++};
        for (const HdIrtEntry& entry : shape.entries)
            picks[HdIrtObjectId(shape.instancer + "[" + std::to_string(entry.key) + "]")] = {
                shape.prim_id, static_cast<std::int32_t>(entry.key)};
    }
    return picks;
}

PXR_NAMESPACE_CLOSE_SCOPE
