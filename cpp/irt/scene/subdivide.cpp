// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/subdivide.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "irt/math/bits.h"
#include "irt/scene/control_cage.h"

namespace irt {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

constexpr int max_level = 8;

/// What OpenSubdiv interpolates: as many as four numbers, in double.
struct Value {
    std::array<double, 4> c{};
    void Clear() { c = {}; }
    void AddWithWeight(const Value& value, double weight) {
        for (std::size_t i = 0; i < c.size(); ++i) c[i] += weight * value.c[i];
    }
    [[nodiscard]] V3d xyz() const { return {c[0], c[1], c[2]}; }
};
using Values = std::vector<Value>;

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

/// Whether the surface breaks along an edge that two faces share: its sides have normals of their
/// own. (What sharpness is left at the last level is taken for infinite, as limit positions do.)
bool is_split(const Far::TopologyLevel& level, Far::Index edge) {
    return level.IsEdgeNonManifold(edge) ||
           (level.GetEdgeSharpness(edge) > 0 && !level.IsEdgeBoundary(edge));
}

/// The faces around `vertex`, numbered by the side of what is sharp that they are on.
std::vector<int> sides(const Far::TopologyLevel& level, Far::Index vertex) {
    const Far::ConstIndexArray faces = level.GetVertexFaces(vertex);
    std::vector<int> side(static_cast<std::size_t>(faces.size()));
    for (std::size_t i = 0; i < side.size(); ++i) side[i] = static_cast<int>(i);
    for (const Far::Index edge : level.GetVertexEdges(vertex)) {
        if (is_split(level, edge) || level.GetEdgeFaces(edge).size() != 2) continue;
        const Far::ConstIndexArray pair = level.GetEdgeFaces(edge);
        const auto at = [&](int k) {
            return side[static_cast<std::size_t>(faces.FindIndex(pair[k]))];
        };
        const int keep = std::min(at(0), at(1)), drop = std::max(at(0), at(1));
        std::replace(side.begin(), side.end(), drop, keep);
    }
    return side;
}

V3f unit(const V3d& v, bool flip) {
    const double length = std::sqrt(v.dot(v));
    if (!(length > 0) || !std::isfinite(length)) return {0, 0, 0};
    return V3f(divided(flip ? -v : v, length));
}

/// The values that corners of a face-varying primvar show: its indices, or each its own.
std::vector<std::int32_t> channel_of(const Primvar& primvar, std::size_t corners) {
    if (!primvar.indices.empty()) return primvar.indices;
    std::vector<std::int32_t> own(corners);
    for (std::size_t i = 0; i < corners; ++i) own[i] = static_cast<std::int32_t>(i);
    return own;
}

Values values_of(const Primvar& primvar, bool flattened) {
    const auto width = static_cast<std::size_t>(primvar.width);
    const bool indexed = flattened && !primvar.indices.empty();
    Values values(indexed ? primvar.indices.size() : primvar.values.size() / width);
    for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t k = 0; k < width; ++k) {
            const std::size_t at = indexed ? static_cast<std::size_t>(primvar.indices[i]) : i;
            values[i].c[k] = static_cast<double>(primvar.values[at * width + k]);
        }
    return values;
}

std::vector<float> narrowed(const Values& values, int width) {
    std::vector<float> out;
    out.reserve(values.size() * static_cast<std::size_t>(width));
    for (const Value& value : values)
        for (std::size_t k = 0; k < static_cast<std::size_t>(width); ++k)
            out.push_back(static_cast<float>(value.c[k]));
    return out;
}

}  // namespace

struct Subdivider::Topology {
    std::size_t points = 0;                           ///< of the cage
    std::vector<std::int32_t> counts, indices;        ///< of the cage
    std::vector<std::vector<std::int32_t>> channels;  ///< of its face-varying primvars
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::vector<std::int32_t> faces;       ///< refined ones that are no hole
    std::vector<std::int32_t> base_faces;  ///< of `faces`: the face of the cage they are in
    std::vector<bool> creased;             ///< refined vertices that are not smooth all around

    [[nodiscard]] const Far::TopologyLevel& last() const {
        return refiner->GetLevel(refiner->GetMaxLevel());
    }
    /// To mesh.normals; `limits` and two tangents at each vertex.
    void set_normals(const Values& limits, const Values& first, const Values& second,
                     Mesh& mesh) const;

    using Refiner = Far::PrimvarRefinerReal<double>;

    /// `values` of the cage taken to the last level by `step`.
    template <class Step>
    Values refined(Values values, Step&& step) const {
        for (int level = 1; level <= refiner->GetMaxLevel(); ++level) {
            Values next(static_cast<std::size_t>(step.count(refiner->GetLevel(level))));
            step(level, values, next);
            values = std::move(next);
        }
        return values;
    }
};

namespace {

struct AsPoints {
    const Far::PrimvarRefinerReal<double>& refiner;
    static int count(const Far::TopologyLevel& level) { return level.GetNumVertices(); }
    void operator()(int level, const Values& from, Values& to) const {
        Value* out = to.data();
        refiner.Interpolate(level, from.data(), out);
    }
};
struct AsVarying {
    const Far::PrimvarRefinerReal<double>& refiner;
    static int count(const Far::TopologyLevel& level) { return level.GetNumVertices(); }
    void operator()(int level, const Values& from, Values& to) const {
        Value* out = to.data();
        refiner.InterpolateVarying(level, from.data(), out);
    }
};
struct AsFaceVarying {
    const Far::PrimvarRefinerReal<double>& refiner;
    int channel;
    [[nodiscard]] int count(const Far::TopologyLevel& level) const {
        return level.GetNumFVarValues(channel);
    }
    void operator()(int level, const Values& from, Values& to) const {
        Value* out = to.data();
        refiner.InterpolateFaceVarying(level, from.data(), out, channel);
    }
};

}  // namespace

void Subdivider::Topology::set_normals(const Values& limits, const Values& first,
                                       const Values& second, Mesh& mesh) const {
    std::vector<V3f> smooth(limits.size());
    for (std::size_t v = 0; v < limits.size(); ++v)
        smooth[v] = unit(first[v].xyz().cross(second[v].xyz()), mesh.left_handed);
    const bool any = std::find(creased.begin(), creased.end(), true) != creased.end();
    mesh.normals_interpolation = any ? Interpolation::FaceVarying : Interpolation::Vertex;
    if (!any) {
        mesh.normals = std::move(smooth);
        return;
    }
    // At what is sharp: of the faces on a side, the sum of the cross products at their corners.
    const Far::TopologyLevel& level = last();
    const auto cross = [&](Far::Index face, int k) {
        const Far::ConstIndexArray corners = level.GetFaceVertices(face);
        const int n = corners.size();
        const auto at = [&](int i) {
            return limits[static_cast<std::size_t>(corners[i % n])].xyz();
        };
        return (at(k + 1) - at(k)).cross(at(k + n - 1) - at(k));
    };
    for (const std::int32_t face : faces) {
        const Far::ConstIndexArray corners = level.GetFaceVertices(face);
        for (int k = 0; k < corners.size(); ++k) {
            const Far::Index v = corners[k];
            if (!creased[static_cast<std::size_t>(v)]) {
                mesh.normals.push_back(smooth[static_cast<std::size_t>(v)]);
                continue;
            }
            const Far::ConstIndexArray around = level.GetVertexFaces(v);
            const Far::ConstLocalIndexArray places = level.GetVertexFaceLocalIndices(v);
            const std::vector<int> side = sides(level, v);
            const int mine = side[static_cast<std::size_t>(around.FindIndex(face))];
            V3d sum(0);
            for (int i = 0; i < around.size(); ++i)
                if (side[static_cast<std::size_t>(i)] == mine) sum += cross(around[i], places[i]);
            mesh.normals.push_back(unit(sum, mesh.left_handed));
        }
    }
}

Subdivider::Subdivider(Subdivision rules) : rules_(std::move(rules)) {
    require(rules_.level >= 0 && rules_.level <= max_level, "the level must be 0 to 8");
    std::size_t indices = 0, edges = 0;
    for (const std::int32_t length : rules_.crease_lengths) {
        require(length >= 2, "a crease length is below 2");
        indices += static_cast<std::size_t>(length);
        edges += static_cast<std::size_t>(length) - 1;
    }
    require(indices == rules_.crease_indices.size(),
            "the creaseLengths do not sum to the number of creaseIndices");
    require(rules_.crease_sharpnesses.size() == rules_.crease_lengths.size() ||
                rules_.crease_sharpnesses.size() == edges,
            "there are neither as many creaseSharpnesses as creases nor as their edges");
    require(rules_.corner_sharpnesses.size() == rules_.corner_indices.size(),
            "there are not as many cornerSharpnesses as cornerIndices");
}
Subdivider::~Subdivider() = default;
Subdivider::Subdivider(Subdivider&&) noexcept = default;
Subdivider& Subdivider::operator=(Subdivider&&) noexcept = default;

bool Subdivider::known(const Mesh& cage) const {
    if (!topology_ || topology_->points != cage.points.size() ||
        !same_bits(topology_->counts, cage.face_vertex_counts) ||
        !same_bits(topology_->indices, cage.face_vertex_indices))
        return false;
    std::size_t channel = 0;
    for (const Primvar& primvar : cage.primvars) {
        if (primvar.interpolation != Interpolation::FaceVarying) continue;
        if (channel == topology_->channels.size() ||
            !same_bits(topology_->channels[channel],
                       channel_of(primvar, cage.face_vertex_indices.size())))
            return false;
        ++channel;
    }
    return channel == topology_->channels.size();
}

std::unique_ptr<Subdivider::Topology> Subdivider::make_topology(const Mesh& cage) const {
    auto topology = std::make_unique<Topology>();
    topology->points = cage.points.size();
    topology->counts = cage.face_vertex_counts;
    topology->indices = cage.face_vertex_indices;

    const auto names = [](const std::vector<std::int32_t>& indices, std::size_t count) {
        return std::all_of(indices.begin(), indices.end(), [count](std::int32_t i) {
            return i >= 0 && static_cast<std::size_t>(i) < count;
        });
    };
    require(names(rules_.crease_indices, cage.points.size()),
            "creaseIndices name points that are not there");
    require(names(rules_.corner_indices, cage.points.size()),
            "cornerIndices name points that are not there");
    require(names(rules_.hole_indices, cage.face_vertex_counts.size()),
            "holeIndices name faces that are not there");
    const int corners = rules_.scheme == SubdivisionScheme::Loop ? 3 : 0;
    for (const std::int32_t count : cage.face_vertex_counts) {
        require(count >= 3, "a face has fewer than 3 vertices");
        require(corners == 0 || count == corners, "Loop subdivision takes triangles alone");
    }

    // One sharpness an edge, as OpenSubdiv wants them.
    std::vector<Far::Index> pairs;
    std::vector<float> sharpnesses;
    const bool by_crease = rules_.crease_sharpnesses.size() == rules_.crease_lengths.size();
    std::size_t first = 0, edge = 0;
    for (std::size_t k = 0; k < rules_.crease_lengths.size(); ++k) {
        const auto length = static_cast<std::size_t>(rules_.crease_lengths[k]);
        for (std::size_t i = first; i + 1 < first + length; ++i, ++edge) {
            pairs.push_back(rules_.crease_indices[i]);
            pairs.push_back(rules_.crease_indices[i + 1]);
            sharpnesses.push_back(std::max(0.0f, rules_.crease_sharpnesses[by_crease ? k : edge]));
        }
        first += length;
    }
    std::vector<float> corner_sharpnesses = rules_.corner_sharpnesses;
    for (float& sharpness : corner_sharpnesses) sharpness = std::max(0.0f, sharpness);

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
    descriptor.cornerVertexIndices = rules_.corner_indices.data();
    descriptor.cornerWeights = corner_sharpnesses.data();
    descriptor.numHoles = static_cast<int>(rules_.hole_indices.size());
    descriptor.holeIndices = rules_.hole_indices.data();
    descriptor.numFVarChannels = static_cast<int>(channels.size());
    descriptor.fvarChannels = channels.data();

    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Far::SetErrorCallback(silent);
    Far::SetWarningCallback(silent);
    topology->refiner.reset(Factory::Create(
        descriptor, Factory::Options(scheme_of(rules_.scheme), options_of(rules_))));
    require(topology->refiner != nullptr, "OpenSubdiv refuses the topology");
    Far::TopologyRefiner::UniformOptions uniform(rules_.level);
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

Mesh Subdivider::refine(const Mesh& cage) {
    if (rules_.level == 0) return control_cage(cage, rules_);
    if (!known(cage)) topology_ = make_topology(cage);
    const Topology& topology = *topology_;
    const Far::TopologyLevel& last = topology.last();
    const Topology::Refiner refiner(*topology.refiner);
    const auto vertices = static_cast<std::size_t>(last.GetNumVertices());
    const auto limit = [&](const Values& values) {
        Values out(values.size());
        Value* to = out.data();
        refiner.Limit(values.data(), to);
        return out;
    };

    Mesh mesh;
    mesh.left_handed = cage.left_handed;
    mesh.single_sided = cage.single_sided;
    for (const std::int32_t face : topology.faces) {
        const Far::ConstIndexArray corners = last.GetFaceVertices(face);
        mesh.face_vertex_counts.push_back(corners.size());
        for (const Far::Index vertex : corners) mesh.face_vertex_indices.push_back(vertex);
    }

    Values points(cage.points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const V3d p(cage.points[i]);
        points[i].c = {p.x, p.y, p.z, 0};
    }
    points = topology.refined(std::move(points), AsPoints{refiner});
    Values limits(vertices), across(vertices), along(vertices);
    {
        Value *to = limits.data(), *first = across.data(), *second = along.data();
        refiner.Limit(points.data(), to, first, second);
    }
    mesh.points.reserve(vertices);
    for (const Value& p : limits) mesh.points.emplace_back(V3f(p.xyz()));
    if (rules_.scheme != SubdivisionScheme::Bilinear) {
        topology.set_normals(limits, across, along, mesh);
    }

    int channel = 0;
    for (const Primvar& primvar : cage.primvars) {
        Primvar& out = mesh.primvars.emplace_back();
        out.name = primvar.name;
        out.width = primvar.width;
        out.interpolation = primvar.interpolation;
        switch (primvar.interpolation) {
            case Interpolation::None:
            case Interpolation::Constant:
                out = primvar;
                break;
            case Interpolation::Uniform:
                out.values = primvar.values;
                for (const std::int32_t face : topology.base_faces)
                    out.indices.push_back(primvar.indices.empty()
                                              ? face
                                              : primvar.indices[static_cast<std::size_t>(face)]);
                break;
            case Interpolation::Varying:
                out.values = narrowed(
                    topology.refined(values_of(primvar, true), AsVarying{refiner}), out.width);
                break;
            case Interpolation::Vertex:
                out.values =
                    narrowed(limit(topology.refined(values_of(primvar, true), AsPoints{refiner})),
                             out.width);
                break;
            case Interpolation::FaceVarying: {
                const Values refined =
                    topology.refined(values_of(primvar, false), AsFaceVarying{refiner, channel});
                Values at_limit(refined.size());
                Value* to = at_limit.data();
                refiner.LimitFaceVarying(refined.data(), to, channel);
                out.values = narrowed(at_limit, out.width);
                for (const std::int32_t face : topology.faces)
                    for (const Far::Index value : last.GetFaceFVarValues(face, channel))
                        out.indices.push_back(value);
                ++channel;
                break;
            }
        }
    }
    if (!cage.face_materials.empty())
        for (const std::int32_t face : topology.base_faces)
            mesh.face_materials.push_back(cage.face_materials[static_cast<std::size_t>(face)]);
    return mesh;
}

Mesh subdivide(const Mesh& cage, const Subdivision& rules) {
    return Subdivider(rules).refine(cage);
}

}  // namespace irt
