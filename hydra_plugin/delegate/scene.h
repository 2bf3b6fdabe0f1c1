// SPDX-License-Identifier: Apache-2.0
// The scene as Hydra has told of it, and the change sets that bring the core up to it.
#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "irt/scene/change_set.h"
#include "pxr/base/tf/token.h"
#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/usd/sdf/path.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Where an rprim's instances are.
struct HdIrtPlacement {
    std::string name;  ///< of the object
    irt::M44d world_from_object;
};

/// One entry of a point instancer, by its number there.
struct HdIrtEntry {
    std::int64_t key;
    irt::Affine array_from_prototype;
};

/// What an rprim draws.
struct HdIrtShape {
    irt::Geometry geometry;
    std::string material;                     ///< bound; empty: none
    std::optional<irt::Material> own;         ///< what stands in where there is none
    irt::Primvars primvars;                   ///< constant ones, of shapes without vertices
    std::vector<std::string> face_materials;  ///< as irt::Object has them
    TfToken render_tag;
    std::set<std::string> categories;  ///< of light linking
    std::int32_t prim_id = -1;
    bool visible = true;

    std::vector<HdIrtPlacement> placements;  ///< as objects of their own
    bool native = false;                     ///< they share the shape as instances do

    std::string instancer;            ///< the point instancer that draws it; empty: none
    irt::M44d prototype_from_object;  ///< then
    std::vector<HdIrtEntry> entries;  ///< then
};

/// A point instancer's place: in the world, or in its parent's prototypes.
struct HdIrtInstancerPlace {
    irt::M44d world_from_array;
    std::string parent;               ///< empty: none
    std::vector<HdIrtEntry> entries;  ///< where it has one
    bool visible = true;
};

/// A light, and the category by which objects are linked to it; empty: it lights all.
struct HdIrtLight {
    std::map<std::string, irt::Light> records;  ///< a dome is several
    std::string link;
};

/// Which rprim an object of the scene is, and which instance of it.
struct HdIrtPick {
    std::int32_t prim_id, instance_id;
};

/// Filled by syncs, from any thread; emptied by the render thread.
class HdIrtScene {
  public:
    void SetShape(const SdfPath& id, HdIrtShape shape);
    void RemoveShape(const SdfPath& id);
    void SetInstancer(const SdfPath& id, const std::string& name, HdIrtInstancerPlace place);
    void RemoveInstancer(const SdfPath& id);
    void SetMaterial(const SdfPath& id, const std::string& name, irt::Material material);
    void RemoveMaterial(const SdfPath& id);
    void SetLight(const SdfPath& id, HdIrtLight light);
    void RemoveLight(const SdfPath& id);
    /// What is drawn: shapes of these tags; all, if there are none.
    void SetRenderTags(const TfTokenVector& tags);
    /// The light that stands in where the scene has none.
    void SetCameraLight(const std::optional<irt::Light>& light);

    /// Primvars that the material of that name reads; null where it is not known.
    [[nodiscard]] std::set<std::string> PrimvarsOf(const std::string& material) const;

    /// What changed since the last call, in whole records; with `all`, everything there is.
    irt::ChangeSet Take(bool all);
    /// Grows with every change.
    [[nodiscard]] std::uint64_t Serial() const { return _serial; }
    /// By object id (irt::ObjectSlot::id).
    [[nodiscard]] std::unordered_map<std::uint32_t, HdIrtPick> Picks() const;

  private:
    struct Material {
        std::string name;
        irt::Material record;
    };
    using Records = std::map<std::string, irt::Object>;
    using Own = std::map<std::string, irt::Material>;  ///< that stand in for bound ones
    /// Names that the core knows.
    struct Told {
        std::set<std::string> objects, materials;
    };

    void _Touch() {
        _changed = true;
        ++_serial;
    }
    [[nodiscard]] bool _Drawn(const HdIrtShape& shape) const;
    /// The material that an object of that name wears.
    [[nodiscard]] std::string _Worn(const std::string& name, const HdIrtShape& shape,
                                    Own& own) const;
    [[nodiscard]] std::vector<std::string> _FaceMaterials(const HdIrtShape& shape,
                                                          const std::string& otherwise) const;
    [[nodiscard]] irt::Part _PartOf(const std::string& name, const HdIrtShape& shape,
                                    const irt::M44d& placed, Own& own) const;
    void _AddObjects(const HdIrtShape& shape, Records& objects, Own& own) const;
    void _AddArrays(Records& objects, Own& own) const;
    [[nodiscard]] std::vector<std::string> _Unlit(const std::string& link) const;

    static void _Tell(irt::ChangeSet& changes, Told& told, Records objects, const Own& own);
    void _AssembleMaterials(irt::ChangeSet& changes, bool all);
    void _AssembleObjects(irt::ChangeSet& changes, bool all);
    void _AssembleLights(irt::ChangeSet& changes, bool all);

    mutable std::mutex _mutex;
    std::atomic<std::uint64_t> _serial = 0;
    bool _changed = false;
    std::map<SdfPath, HdIrtShape> _shapes;
    std::map<SdfPath, std::pair<std::string, HdIrtInstancerPlace>> _instancers;
    std::map<SdfPath, Material> _materials;
    std::map<SdfPath, HdIrtLight> _lights;
    std::set<SdfPath> _changedShapes, _changedMaterials;
    std::set<TfToken> _tags;
    bool _arraysChanged = false, _lightsChanged = false, _allChanged = false;
    std::optional<irt::Light> _cameraLight;

    std::map<SdfPath, Told> _toldObjects;  ///< by rprim
    Told _toldArrays;
    std::set<std::string> _toldMaterials, _toldLights;
};

PXR_NAMESPACE_CLOSE_SCOPE
