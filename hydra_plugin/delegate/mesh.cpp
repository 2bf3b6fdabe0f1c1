// SPDX-License-Identifier: Apache-2.0
#include "delegate/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "delegate/convert.h"
#include "pxr/imaging/hd/geomSubset.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/imaging/pxOsd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

bool Subdivided(const HdMeshTopology& topology) {
    const TfToken& scheme = topology.GetScheme();
    return scheme == PxOsdOpenSubdivTokens->catmullClark || scheme == PxOsdOpenSubdivTokens->loop ||
           scheme == PxOsdOpenSubdivTokens->bilinear;
}

irt::Subdivision Rules(const HdMeshTopology& topology, int level) {
    using Boundary = irt::BoundaryRule;
    using FaceVarying = irt::FaceVaryingRule;
    const PxOsdSubdivTags& tags = topology.GetSubdivTags();
    irt::Subdivision rules;
    rules.level = level;
    if (topology.GetScheme() == PxOsdOpenSubdivTokens->loop)
        rules.scheme = irt::SubdivisionScheme::Loop;
    if (topology.GetScheme() == PxOsdOpenSubdivTokens->bilinear)
        rules.scheme = irt::SubdivisionScheme::Bilinear;
    const TfToken boundary = tags.GetVertexInterpolationRule();
    if (boundary == PxOsdOpenSubdivTokens->none) rules.boundary = Boundary::None;
    if (boundary == PxOsdOpenSubdivTokens->edgeOnly) rules.boundary = Boundary::EdgeOnly;
    const std::pair<TfToken, FaceVarying> linear[] = {
        {PxOsdOpenSubdivTokens->none, FaceVarying::None},
        {PxOsdOpenSubdivTokens->cornersOnly, FaceVarying::CornersOnly},
        {PxOsdOpenSubdivTokens->cornersPlus1, FaceVarying::CornersPlus1},
        {PxOsdOpenSubdivTokens->cornersPlus2, FaceVarying::CornersPlus2},
        {PxOsdOpenSubdivTokens->boundaries, FaceVarying::Boundaries},
        {PxOsdOpenSubdivTokens->all, FaceVarying::All}};
    for (const auto& [token, rule] : linear)
        if (tags.GetFaceVaryingInterpolationRule() == token) rules.face_varying = rule;
    rules.smooth_triangles = tags.GetTriangleSubdivision() == PxOsdOpenSubdivTokens->smooth;
    rules.crease_indices = HdIrtArray(tags.GetCreaseIndices());
    rules.crease_lengths = HdIrtArray(tags.GetCreaseLengths());
    rules.crease_sharpnesses = HdIrtArray(tags.GetCreaseWeights());
    rules.corner_indices = HdIrtArray(tags.GetCornerIndices());
    rules.corner_sharpnesses = HdIrtArray(tags.GetCornerWeights());
    rules.hole_indices = HdIrtArray(topology.GetHoleIndices());
    return rules;
}

/// Takes what belongs to holes out of elements, `size` numbers each.
template <class T>
void Keep(const std::vector<bool>& kept, std::size_t size, std::vector<T>& elements) {
    std::size_t to = 0;
    for (std::size_t i = 0; i < kept.size(); ++i)
        if (kept[i])
            for (std::size_t k = 0; k < size; ++k) elements[to++] = elements[i * size + k];
    elements.resize(to);
}

/// A polygon mesh without the faces that are holes.
void DropHoles(const VtIntArray& holes, irt::Mesh& mesh) {
    if (holes.empty()) return;
    std::vector<bool> faces(mesh.face_vertex_counts.size(), true), corners;
    for (const int hole : holes) faces[static_cast<std::size_t>(hole)] = false;
    for (std::size_t f = 0; f < faces.size(); ++f)
        corners.insert(corners.end(), static_cast<std::size_t>(mesh.face_vertex_counts[f]),
                       faces[f]);
    const auto keep = [&](irt::Interpolation interpolation, std::size_t size, auto& elements) {
        if (interpolation == irt::Interpolation::Uniform) Keep(faces, size, elements);
        if (interpolation == irt::Interpolation::FaceVarying) Keep(corners, size, elements);
    };
    keep(mesh.normals_interpolation, 1, mesh.normals);
    for (irt::Primvar& primvar : mesh.primvars) {
        if (primvar.indices.empty())
            keep(primvar.interpolation, static_cast<std::size_t>(primvar.width), primvar.values);
        else
            keep(primvar.interpolation, 1, primvar.indices);
    }
    if (!mesh.face_materials.empty()) Keep(faces, 1, mesh.face_materials);
    Keep(corners, 1, mesh.face_vertex_indices);
    Keep(faces, 1, mesh.face_vertex_counts);
}

}  // namespace

std::string HdIrtMesh::_Fault(const HdMeshTopology& topology, std::size_t points) const {
    const VtIntArray& counts = topology.GetFaceVertexCounts();
    const VtIntArray& indices = topology.GetFaceVertexIndices();
    std::int64_t corners = 0;
    for (const int count : counts) {
        if (count < 0) return "a face vertex count is negative; expected 3 or more";
        corners += count;
    }
    if (corners != static_cast<std::int64_t>(indices.size()))
        return "the face vertex counts sum to " + std::to_string(corners) + ", but there are " +
               std::to_string(indices.size()) + " face vertex indices; expected as many";
    for (const int index : indices)
        if (index < 0 || static_cast<std::size_t>(index) >= points)
            return "index " + std::to_string(index) + " names none of the " +
                   std::to_string(points) + " points";
    for (const int hole : topology.GetHoleIndices())
        if (hole < 0 || static_cast<std::size_t>(hole) >= counts.size())
            return "a hole names none of the faces";
    return {};
}

std::vector<std::string> HdIrtMesh::_OtherMaterials(HdSceneDelegate& delegate) const {
    std::vector<std::string> names;
    for (const HdGeomSubset& subset : delegate.GetMeshTopology(GetId()).GetGeomSubsets())
        if (!subset.materialId.IsEmpty()) names.push_back(HdIrtName(delegate, subset.materialId));
    return names;
}

bool HdIrtMesh::_ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                              HdIrtShape& shape) {
    const HdMeshTopology topology = delegate.GetMeshTopology(GetId());
    const VtValue value = HdIrtComputedPrimvar(delegate, GetId(), HdTokens->points);
    if (!value.IsHolding<VtVec3fArray>() || topology.GetFaceVertexCounts().empty()) return false;
    const auto& points = value.UncheckedGet<VtVec3fArray>();
    if (points.empty()) return false;
    std::string fault = _Fault(topology, points.size());
    if (!std::all_of(points.cbegin(), points.cend(), [](const GfVec3f& p) {
            return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
        }))
        fault = "its points hold a NaN or an infinity; expected finite numbers";
    if (!fault.empty()) {
        TF_WARN("<%s>: %s; it is not drawn", GetId().GetText(), fault.c_str());
        return false;
    }
    irt::Mesh mesh;
    mesh.points = HdIrtVectors(points);
    mesh.face_vertex_counts = HdIrtArray(topology.GetFaceVertexCounts());
    mesh.face_vertex_indices = HdIrtArray(topology.GetFaceVertexIndices());
    mesh.left_handed = topology.GetOrientation() == HdTokens->leftHanded;
    const HdCullStyle cull = delegate.GetCullStyle(GetId());
    mesh.single_sided = cull == HdCullStyleBack;
    const auto count = [&](irt::Interpolation interpolation) -> std::size_t {
        switch (interpolation) {
            case irt::Interpolation::Constant:
                return 1;
            case irt::Interpolation::Uniform:
                return mesh.face_vertex_counts.size();
            case irt::Interpolation::FaceVarying:
                return mesh.face_vertex_indices.size();
            default:
                return mesh.points.size();
        }
    };
    mesh.primvars = HdIrtReadPrimvars(delegate, GetId(), wanted, count);
    _ReadFaceMaterials(delegate, topology, mesh, shape);
    const int level = std::clamp(delegate.GetDisplayStyle(GetId()).refineLevel, 0, 8);
    if (Subdivided(topology)) {
        shape.geometry = std::make_shared<const irt::Mesh>(_Refined(mesh, topology, level));
        return true;
    }
    _ReadNormals(delegate, mesh);
    DropHoles(topology.GetHoleIndices(), mesh);
    shape.geometry = std::make_shared<const irt::Mesh>(std::move(mesh));
    return true;
}

void HdIrtMesh::_ReadFaceMaterials(HdSceneDelegate& delegate, const HdMeshTopology& topology,
                                   irt::Mesh& mesh, HdIrtShape& shape) const {
    shape.face_materials.clear();
    std::vector<std::int32_t> faces(mesh.face_vertex_counts.size(), -1);
    bool any = false;
    for (const HdGeomSubset& subset : topology.GetGeomSubsets()) {
        if (subset.materialId.IsEmpty() || subset.type != HdGeomSubset::TypeFaceSet) continue;
        const std::string name = HdIrtName(delegate, subset.materialId);
        auto at = std::find(shape.face_materials.begin(), shape.face_materials.end(), name);
        const auto place = static_cast<std::int32_t>(at - shape.face_materials.begin());
        if (at == shape.face_materials.end()) shape.face_materials.push_back(name);
        bool outside = false;
        for (const int face : subset.indices) {
            if (face < 0 || static_cast<std::size_t>(face) >= faces.size()) {
                outside = true;
            } else if (faces[static_cast<std::size_t>(face)] == -1) {
                faces[static_cast<std::size_t>(face)] = place;
                any = true;
            }
        }
        if (outside)
            TF_WARN("<%s>: a subset names faces that are not there; they are left out",
                    subset.id.GetText());
    }
    if (any)
        mesh.face_materials = std::move(faces);
    else
        shape.face_materials.clear();
}

void HdIrtMesh::_ReadNormals(HdSceneDelegate& delegate, irt::Mesh& mesh) const {
    const auto primvar = HdIrtReadPrimvar(delegate, GetId(), HdTokens->normals.GetString());
    if (!primvar || primvar->values.empty()) return;
    irt::Interpolation interpolation = primvar->interpolation;
    if (interpolation == irt::Interpolation::Varying) interpolation = irt::Interpolation::Vertex;
    const std::size_t expected =
        interpolation == irt::Interpolation::Constant      ? 1
        : interpolation == irt::Interpolation::Uniform     ? mesh.face_vertex_counts.size()
        : interpolation == irt::Interpolation::FaceVarying ? mesh.face_vertex_indices.size()
                                                           : mesh.points.size();
    if (primvar->width != 3 || HdIrtElements(*primvar) != expected) {
        TF_WARN("<%s>: there are %zu normals; expected %zu; facets are rendered instead",
                GetId().GetText(), HdIrtElements(*primvar), expected);
        return;
    }
    for (std::size_t i = 0; i < expected; ++i) {
        const std::size_t at =
            3 * (primvar->indices.empty() ? i : static_cast<std::size_t>(primvar->indices[i]));
        mesh.normals.emplace_back(primvar->values[at], primvar->values[at + 1],
                                  primvar->values[at + 2]);
    }
    mesh.normals_interpolation = interpolation;
}

irt::Mesh HdIrtMesh::_Refined(const irt::Mesh& cage, const HdMeshTopology& topology, int level) {
    try {
        if (!_subdivider || _level != level || topology != _topology) {
            _subdivider.emplace(Rules(topology, level));
            _topology = topology;
            _level = level;
        }
        return _subdivider->refine(cage);
    } catch (const std::invalid_argument& error) {
        _subdivider.reset();
        TF_WARN("<%s>: not subdivided, the control cage is rendered: %s", GetId().GetText(),
                error.what());
        irt::Subdivision plain;
        plain.scheme = Rules(topology, 0).scheme;
        plain.hole_indices = HdIrtArray(topology.GetHoleIndices());
        return irt::subdivide(cage, plain);
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
