// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/refined_topology.h"

#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <stdexcept>

namespace irt {

namespace {

namespace Sdc = OpenSubdiv::Sdc;

Sdc::SchemeType scheme_of(SubdivisionScheme scheme) {
    if (scheme == SubdivisionScheme::Loop) return Sdc::SCHEME_LOOP;
    return scheme == SubdivisionScheme::Bilinear ? Sdc::SCHEME_BILINEAR : Sdc::SCHEME_CATMARK;
}

Sdc::Options options_of(const Subdivision& rules) {
    Sdc::Options options;
    // OpenSubdiv drops the boundary faces of bilinear meshes without a boundary rule.
    const BoundaryRule boundary =
        rules.scheme == SubdivisionScheme::Bilinear ? BoundaryRule::EdgeAndCorner : rules.boundary;
    options.SetVtxBoundaryInterpolation(
        boundary == BoundaryRule::None       ? Sdc::Options::VTX_BOUNDARY_NONE
        : boundary == BoundaryRule::EdgeOnly ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                             : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    switch (rules.face_varying) {
        case FaceVaryingRule::None:
            options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_NONE);
            break;
        case FaceVaryingRule::CornersOnly:
            options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_ONLY);
            break;
        case FaceVaryingRule::CornersPlus1:
            options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1);
            break;
        case FaceVaryingRule::CornersPlus2:
            options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2);
            break;
        case FaceVaryingRule::Boundaries:
            options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_BOUNDARIES);
            break;
        case FaceVaryingRule::All:
            options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_ALL);
            break;
    }
    options.SetTriangleSubdivision(rules.smooth_triangles ? Sdc::Options::TRI_SUB_SMOOTH
                                                          : Sdc::Options::TRI_SUB_CATMARK);
    return options;
}

void silent(Far::ErrorType, const char*) {}
void silent(const char*) {}

void require(bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
}

bool names(std::int32_t index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
}

std::string missing(const char* what, std::size_t which, std::int32_t index, std::size_t points) {
    return std::string(what) + " " + std::to_string(which) + ": it names point " +
           std::to_string(index) + ", but there are " + std::to_string(points);
}

}  // namespace

bool is_split(const Far::TopologyLevel& level, Far::Index edge) {
    return level.IsEdgeNonManifold(edge) ||
           (level.GetEdgeSharpness(edge) > 0 && !level.IsEdgeBoundary(edge));
}

std::vector<std::int32_t> channel_of(const Primvar& primvar, std::size_t corners) {
    if (!primvar.indices.empty()) return primvar.indices;
    std::vector<std::int32_t> own(corners);
    for (std::size_t i = 0; i < corners; ++i) own[i] = static_cast<std::int32_t>(i);
    return own;
}

std::unique_ptr<RefinedTopology> refined_topology(const Mesh& cage, const Subdivision& rules,
                                                  std::vector<std::string>& left_out) {
    auto topology = std::make_unique<RefinedTopology>();
    topology->points = cage.points.size();
    topology->counts = cage.face_vertex_counts;
    topology->indices = cage.face_vertex_indices;

    for (const std::int32_t face : rules.hole_indices)
        require(names(face, cage.face_vertex_counts.size()),
                "holeIndices name faces that are not there");
    const int corners = rules.scheme == SubdivisionScheme::Loop ? 3 : 0;
    for (const std::int32_t count : cage.face_vertex_counts) {
        require(count >= 3, "a face has fewer than 3 vertices");
        require(corners == 0 || count == corners, "Loop subdivision takes triangles alone");
    }

    // One sharpness an edge, as OpenSubdiv wants them.
    std::vector<Far::Index> pairs;
    std::vector<float> sharpnesses;
    const bool by_crease = rules.crease_sharpnesses.size() == rules.crease_lengths.size();
    std::size_t first = 0, edge = 0;
    for (std::size_t k = 0; k < rules.crease_lengths.size(); ++k) {
        const auto length = static_cast<std::size_t>(rules.crease_lengths[k]);
        const auto begin = rules.crease_indices.begin() + static_cast<std::ptrdiff_t>(first);
        const auto wrong =
            std::find_if(begin, begin + static_cast<std::ptrdiff_t>(length),
                         [&](std::int32_t i) { return !names(i, topology->points); });
        if (wrong != begin + static_cast<std::ptrdiff_t>(length)) {
            left_out.push_back(missing("crease", k, *wrong, topology->points));
            first += length;
            edge += length - 1;
            continue;
        }
        for (std::size_t i = first; i + 1 < first + length; ++i, ++edge) {
            pairs.push_back(rules.crease_indices[i]);
            pairs.push_back(rules.crease_indices[i + 1]);
            sharpnesses.push_back(std::max(0.0f, rules.crease_sharpnesses[by_crease ? k : edge]));
        }
        first += length;
    }
    std::vector<Far::Index> corner_indices;
    std::vector<float> corner_sharpnesses;
    for (std::size_t k = 0; k < rules.corner_indices.size(); ++k) {
        if (!names(rules.corner_indices[k], topology->points)) {
            left_out.push_back(missing("corner", k, rules.corner_indices[k], topology->points));
            continue;
        }
        corner_indices.push_back(rules.corner_indices[k]);
        corner_sharpnesses.push_back(std::max(0.0f, rules.corner_sharpnesses[k]));
    }

    std::vector<Far::TopologyDescriptor::FVarChannel> channels;
    for (const Primvar& primvar : cage.primvars) {
        if (primvar.interpolation != Interpolation::FaceVarying) continue;
        topology->channels.push_back(channel_of(primvar, cage.face_vertex_indices.size()));
        const auto width = static_cast<std::size_t>(primvar.width);
        channels.emplace_back();
        channels.back().numValues = static_cast<int>(primvar.values.size() / width);
    }
    for (std::size_t i = 0; i < channels.size(); ++i)
        channels[i].valueIndices = topology->channels[i].data();

    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = static_cast<int>(cage.points.size());
    descriptor.numFaces = static_cast<int>(cage.face_vertex_counts.size());
    descriptor.numVertsPerFace = cage.face_vertex_counts.data();
    descriptor.vertIndicesPerFace = cage.face_vertex_indices.data();
    descriptor.numCreases = static_cast<int>(sharpnesses.size());
    descriptor.creaseVertexIndexPairs = pairs.data();
    descriptor.creaseWeights = sharpnesses.data();
    descriptor.numCorners = static_cast<int>(corner_sharpnesses.size());
    descriptor.cornerVertexIndices = corner_indices.data();
    descriptor.cornerWeights = corner_sharpnesses.data();
    descriptor.numHoles = static_cast<int>(rules.hole_indices.size());
    descriptor.holeIndices = rules.hole_indices.data();
    descriptor.numFVarChannels = static_cast<int>(channels.size());
    descriptor.fvarChannels = channels.data();

    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Far::SetErrorCallback(silent);
    Far::SetWarningCallback(silent);
    topology->refiner.reset(
        Factory::Create(descriptor, Factory::Options(scheme_of(rules.scheme), options_of(rules))));
    require(topology->refiner != nullptr, "OpenSubdiv refuses the topology");
    const Far::TopologyLevel& unrefined = topology->refiner->GetLevel(0);
    for (std::size_t i = 0; i < pairs.size(); i += 2)
        if (unrefined.FindEdge(pairs[i], pairs[i + 1]) == Far::INDEX_INVALID)
            left_out.push_back("a crease from point " + std::to_string(pairs[i]) + " to point " +
                               std::to_string(pairs[i + 1]) + ": no edge joins them");
    Far::TopologyRefiner::UniformOptions uniform(rules.level);
    uniform.fullTopologyInLastLevel = true;  // limits ask for it
    topology->refiner->RefineUniform(uniform);

    const Far::TopologyLevel& last = topology->last();
    std::vector<std::int32_t> base(static_cast<std::size_t>(last.GetNumFaces()));
    for (Far::Index face = 0; face < last.GetNumFaces(); ++face) {
        Far::Index parent = face;
        for (int level = topology->refiner->GetMaxLevel(); level > 0; --level)
            parent = topology->refiner->GetLevel(level).GetFaceParentFace(parent);
        if (last.IsFaceHole(face)) continue;
        topology->faces.push_back(face);
        topology->base_faces.push_back(parent);
    }
    topology->creased.resize(static_cast<std::size_t>(last.GetNumVertices()));
    for (Far::Index e = 0; e < last.GetNumEdges(); ++e)
        if (is_split(last, e))
            for (const Far::Index v : last.GetEdgeVertices(e))
                topology->creased[static_cast<std::size_t>(v)] = true;
    for (Far::Index v = 0; v < last.GetNumVertices(); ++v)
        if (last.GetVertexSharpness(v) > 0 || last.IsVertexNonManifold(v))
            topology->creased[static_cast<std::size_t>(v)] = true;
    return topology;
}

}  // namespace irt
