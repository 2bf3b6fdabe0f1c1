// SPDX-License-Identifier: Apache-2.0
// Shapes made ready for tracing, and prototypes of them. Made in compile.h.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "irt/scene/placement.h"
#include "irt/scene/records.h"
#include "irt/trace/box.h"

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
    Primvars primvars = {};  ///< constant ones, read where the mesh has none of the name
    PassRole role = {};      ///< of a part; an object's is in its record

    /// Slot of the material of a triangle (of a quadric: 0).
    [[nodiscard]] std::uint32_t material_of(std::uint32_t primitive) const {
        if (face_materials.empty() || !triangles || triangles->mesh->face_materials.empty())
            return material;
        const std::int32_t face = triangles->mesh->face_materials[triangles->faces[primitive]];
        return face < 0 ? material : face_materials[static_cast<std::size_t>(face)];
    }
    /// Number of the authored face, curve or point that a primitive belongs to (of a solid: 0).
    [[nodiscard]] std::uint32_t element_of(std::uint32_t primitive) const {
        if (curves) return curves->curve_of[primitive];
        if (!triangles) return primitive;
        const std::uint32_t face = triangles->faces[primitive];
        const std::vector<std::int32_t>& elements = triangles->mesh->elements;
        return elements.empty() ? face : static_cast<std::uint32_t>(elements[face]);
    }
};

struct CompiledPrototype;

/// Instances within a prototype. Each has as many part numbers as the largest of its prototypes has
/// parts: `stride`.
struct NestedArray {
    std::shared_ptr<const InstanceArray> record;
    M44d outer_from_array;
    std::vector<std::shared_ptr<const CompiledPrototype>> prototypes;
    std::uint32_t first_part = 0, stride = 1;
    PassRole role = {};

    [[nodiscard]] const CompiledPrototype& prototype(std::size_t entry) const {
        return *prototypes[record->prototype(entry)];
    }
    [[nodiscard]] M44d outer_from_prototype(std::size_t entry) const {
        return placed(record->array_from_prototype[entry], outer_from_array);
    }
};

/// The compiled form of a Prototype, shared by its instances. Its parts are numbered: first the
/// surfaces, then those of the arrays, entry by entry.
struct CompiledPrototype {
    std::vector<Surface> surfaces;
    std::vector<NestedArray> arrays;
    std::uint32_t parts = 0;               ///< numbers in use, and some that are not
    trace::Box box;                        ///< of all parts, in the prototype's space
    std::vector<std::uint32_t> materials;  ///< slots of all that show, increasing
    bool mattes = false;                   ///< some part is matte

    /// Where a part that is no surface lies: array, entry, and number within the entry's prototype.
    struct Located {
        const NestedArray* array;
        std::uint32_t entry, part;
    };
    [[nodiscard]] Located locate(std::uint32_t number) const {
        const NestedArray* array = &arrays.back();
        while (array->first_part > number) --array;
        const std::uint32_t within = number - array->first_part;
        return {array, within / array->stride, within % array->stride};
    }
    /// The surface of that number. Calls enter(array, entry) for each array on the way to it, from
    /// the outermost on.
    template <class Enter>
    [[nodiscard]] const Surface& part(std::uint32_t number, Enter&& enter) const {
        const CompiledPrototype* at = this;
        while (number >= at->surfaces.size()) {
            const auto [array, entry, inner] = at->locate(number);
            enter(*array, entry);
            at = &array->prototype(entry);
            number = inner;
        }
        return at->surfaces[number];
    }
    [[nodiscard]] const Surface& part(std::uint32_t number) const {
        return part(number, [](const NestedArray&, std::uint32_t) {});
    }
};

}  // namespace irt
