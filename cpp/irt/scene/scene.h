// SPDX-License-Identifier: Apache-2.0
// A scene: the records in force, and what tracing and shading read of them. A scene knows no camera
// and no film; several views may show it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "irt/scene/change_set.h"
#include "irt/trace/ray.h"

namespace irt {

/// A mesh made ready for tracing, in trace space: render space for an object of its own, the
/// prototype's space for a part of one. Positions are composed in double and narrowed once.
struct Triangles {
    std::shared_ptr<const Mesh> mesh;  ///< the authored one, for normals
    std::vector<V3f> points;           ///< trace space
    std::vector<std::array<std::uint32_t, 3>>
        triangles;  ///< into points; counter-clockwise seen from the front
    std::vector<std::array<std::uint32_t, 3>> corners;  ///< into mesh->face_vertex_indices
    std::vector<std::uint32_t> faces;                   ///< face of each triangle
};

/// One shape of one material.
struct Surface {
    Quadric quadric;                             ///< read where the pointers are null
    std::shared_ptr<const Triangles> triangles;  ///< a mesh, else null
    std::shared_ptr<const Spheres> spheres;      ///< shape space; null unless spheres
    std::shared_ptr<const Curves> curves;        ///< shape space; null unless curves
    M44d trace_from_shape, shape_from_trace;     ///< shape: the authored object or part space
    std::uint32_t material = 0;                  ///< slot in Scene::materials()
    std::vector<std::uint32_t> face_materials;   ///< slots of what Mesh::face_materials numbers

    /// Slot of the material of a triangle (of a quadric: 0).
    [[nodiscard]] std::uint32_t material_of(std::uint32_t primitive) const {
        if (face_materials.empty() || !triangles || triangles->mesh->face_materials.empty())
            return material;
        const std::int32_t face = triangles->mesh->face_materials[triangles->faces[primitive]];
        return face < 0 ? material : face_materials[static_cast<std::size_t>(face)];
    }
    /// Whether `test` holds of the slot of some material that it may show.
    template <class Test>
    [[nodiscard]] bool any_material(Test&& test) const {
        return test(material) || std::any_of(face_materials.begin(), face_materials.end(), test);
    }
};

/// The compiled form of a Prototype, shared by its instances.
struct CompiledPrototype {
    std::vector<Surface> surfaces;
};

/// An object's slot. A slot belongs to its path for the life of the scene, so that no history can
/// mistake one object for another; `live` is false while there is no object of that path.
struct ObjectSlot {
    bool live = false;
    std::string path;
    std::uint32_t rank = 0;  ///< order of `path` among all paths: ties go to the lower rank
    std::uint32_t id = 0;    ///< MurmurHash3 (x86, 32 bit) of `path`: what id AOVs show
    Object record;
    Surface surface;                                     ///< unless an instance
    std::shared_ptr<const CompiledPrototype> prototype;  ///< an instance's shapes, else null
    M44d render_from_prototype, prototype_from_render;   ///< instances

    [[nodiscard]] const Surface& part(std::uint32_t index) const {
        return prototype ? prototype->surfaces[index] : surface;
    }
    /// Whether `test` holds of the slot of some material that it may show.
    template <class Test>
    [[nodiscard]] bool any_material(Test&& test) const {
        if (!prototype) return surface.any_material(test);
        return std::any_of(prototype->surfaces.begin(), prototype->surfaces.end(),
                           [&](const Surface& part) { return part.any_material(test); });
    }
};

/// A material's slot belongs to its name for the life of the scene.
struct MaterialSlot {
    bool live = false;
    std::string name;
    Material record;
    bool tint_varies = false;  ///< from point to point, by `tint_nodes` of its graph
    std::vector<std::int32_t> tint_nodes;
    trace::OpticalDepth shadow_depth;  ///< else: tint of a shadow ray crossing one primitive of it
};

struct LightSlot {
    std::string path;
    std::uint32_t id = 0;
    Light record;
    V3d position_render;      ///< render space, double
    std::vector<bool> unlit;  ///< by object slot: those it does not light; may end before them
    bool shaped = false;      ///< it does not send the same in all directions

    [[nodiscard]] bool lights(std::uint32_t object) const {
        return object >= unlit.size() || !unlit[object];
    }
};

/// What `Scene::apply` found to differ, record by record and by value.
struct AppliedChanges {
    std::vector<std::uint32_t> geometry;  ///< object slots added, removed, moved or reshaped
    std::vector<ObjectSlot> previous;     ///< of `geometry`: as they were, dead ones left out
    std::vector<std::uint32_t> rebound;   ///< object slots that shade otherwise where hit as before
    std::vector<std::uint32_t> unbound;   ///< of `rebound`: the material slots they had
    std::vector<std::uint32_t> materials;  ///< material slots whose values changed
    std::vector<std::string> lights;       ///< lights added, removed or changed, by path
    std::vector<std::uint32_t> tints;     ///< of `materials`: those that now tint shadows otherwise
    std::vector<std::uint32_t> retinted;  ///< of `rebound`: objects that now tint shadows otherwise
    [[nodiscard]] bool empty() const {
        return geometry.empty() && rebound.empty() && materials.empty() && lights.empty();
    }
};

class Scene {
  public:
    /// `render_origin`: world position that becomes the origin of render space (DESIGN 5).
    explicit Scene(const V3d& render_origin);

    /// Applies `changes`; a record equal to the one in force is no change.
    /// Throws std::invalid_argument, naming the path, on records that cannot be rendered
    /// (singular or non-finite transforms, indices out of range, an unknown material); nothing is
    /// then applied.
    AppliedChanges apply(const ChangeSet& changes);

    [[nodiscard]] const V3d& render_origin() const { return render_origin_; }
    [[nodiscard]] const std::vector<ObjectSlot>& objects() const { return objects_; }
    [[nodiscard]] const std::vector<MaterialSlot>& materials() const { return materials_; }
    /// In path order, lights of no energy left out (DESIGN 3, rule 3).
    [[nodiscard]] const std::vector<LightSlot>& lights() const { return lights_; }
    /// Counts applied change sets that changed anything.
    [[nodiscard]] std::uint64_t version() const { return version_; }

  private:
    struct Prepared;
    [[nodiscard]] Prepared prepare(const ChangeSet& changes) const;
    [[nodiscard]] ObjectSlot compile(const std::string& path, const Object& record,
                                     Prepared& prepared) const;
    [[nodiscard]] ObjectSlot rebind(const ObjectSlot& old, const Object& record,
                                    Prepared& prepared) const;
    void rank_objects();
    void order_lights();

    using SlotOf = std::map<std::string, std::uint32_t>;
    V3d render_origin_;
    std::vector<ObjectSlot> objects_;
    SlotOf object_slots_;
    std::vector<MaterialSlot> materials_;
    SlotOf material_slots_;
    std::map<std::string, Light> light_records_;
    std::vector<LightSlot> lights_;
    std::map<std::shared_ptr<const Prototype>, std::weak_ptr<const CompiledPrototype>> prototypes_;
    std::uint64_t version_ = 0;
};

}  // namespace irt
