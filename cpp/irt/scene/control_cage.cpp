// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/control_cage.h"

#include <cmath>
#include <stdexcept>

namespace irt {

namespace {

/// `values` (one an element, `width` numbers each) of the elements that `kept` says.
template <class T>
std::vector<T> selected(const std::vector<T>& values, const std::vector<bool>& kept,
                        std::size_t width = 1) {
    std::vector<T> out;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (kept[i / width]) out.push_back(values[i]);
    return out;
}

void remove_holes(Mesh& mesh, const Subdivision& rules) {
    const std::vector<std::int32_t>& holes = rules.hole_indices;
    std::vector<bool> faces(mesh.face_vertex_counts.size(), true), corners;
    for (const std::int32_t hole : holes) {
        if (hole < 0 || static_cast<std::size_t>(hole) >= faces.size())
            throw std::invalid_argument("holeIndices name faces that are not there");
        faces[static_cast<std::size_t>(hole)] = false;
    }
    for (std::size_t f = 0; f < faces.size(); ++f)
        corners.insert(corners.end(), static_cast<std::size_t>(mesh.face_vertex_counts[f]),
                       faces[f]);
    for (Primvar& primvar : mesh.primvars) {
        const bool uniform = primvar.interpolation == Interpolation::Uniform;
        if (!uniform && primvar.interpolation != Interpolation::FaceVarying) continue;
        const std::vector<bool>& kept = uniform ? faces : corners;
        if (primvar.indices.empty())
            primvar.values =
                selected(primvar.values, kept, static_cast<std::size_t>(primvar.width));
        else
            primvar.indices = selected(primvar.indices, kept);
    }
    if (!mesh.face_materials.empty()) mesh.face_materials = selected(mesh.face_materials, faces);
    if (rules.name_elements)
        for (std::size_t f = 0; f < faces.size(); ++f)
            if (faces[f]) mesh.elements.push_back(static_cast<std::int32_t>(f));
    mesh.face_vertex_indices = selected(mesh.face_vertex_indices, corners);
    mesh.face_vertex_counts = selected(mesh.face_vertex_counts, faces);
}

/// At each point the sum of the cross products of the edges of its corners.
std::vector<V3f> smooth_normals(const Mesh& mesh) {
    std::vector<V3d> sums(mesh.points.size(), V3d(0));
    std::size_t first = 0;
    for (const std::int32_t face : mesh.face_vertex_counts) {
        const auto count = static_cast<std::size_t>(face);
        const auto vertex = [&](std::size_t k) {
            return static_cast<std::size_t>(mesh.face_vertex_indices[first + k % count]);
        };
        for (std::size_t k = 0; k < count; ++k) {
            const V3d here(mesh.points[vertex(k)]);
            sums[vertex(k)] += (V3d(mesh.points[vertex(k + 1)]) - here)
                                   .cross(V3d(mesh.points[vertex(k + count - 1)]) - here);
        }
        first += count;
    }
    std::vector<V3f> normals;
    normals.reserve(sums.size());
    for (const V3d& sum : sums) {
        const double length = std::sqrt(sum.dot(sum));
        const V3d normal = length > 0 && std::isfinite(length) ? divided(sum, length) : V3d(0);
        normals.emplace_back(V3f(mesh.left_handed ? -normal : normal));
    }
    return normals;
}

}  // namespace

Mesh control_cage(const Mesh& cage, const Subdivision& rules) {
    Mesh mesh = cage;
    if (!rules.hole_indices.empty()) remove_holes(mesh, rules);
    mesh.normals.clear();
    mesh.normals_interpolation = Interpolation::None;
    if (rules.scheme == SubdivisionScheme::Bilinear) return mesh;
    mesh.normals = smooth_normals(mesh);
    mesh.normals_interpolation = Interpolation::Vertex;
    return mesh;
}

}  // namespace irt
