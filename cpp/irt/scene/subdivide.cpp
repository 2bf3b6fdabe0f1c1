// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/subdivide.h"

#include <algorithm>
#include <stdexcept>

#include "irt/math/bits.h"
#include "irt/scene/control_cage.h"
#include "irt/scene/refined_topology.h"

namespace irt {

namespace {

constexpr int max_level = 8;

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

Subdivider::Subdivider(Subdivision rules) : rules_(std::move(rules)) {
    if (rules_.level < 0 || rules_.level > max_level)
        throw std::invalid_argument("the level must be 0 to 8");
    std::size_t indices = 0, edges = 0;
    bool short_crease = false;
    for (const std::int32_t length : rules_.crease_lengths) {
        short_crease = short_crease || length < 2;
        indices += static_cast<std::size_t>(std::max(length, 0));
        edges += static_cast<std::size_t>(std::max(length, 1)) - 1;
    }
    std::string fault;
    if (short_crease)
        fault = "a crease length is below 2";
    else if (indices != rules_.crease_indices.size())
        fault = "the creaseLengths do not sum to the number of creaseIndices";
    else if (rules_.crease_sharpnesses.size() != rules_.crease_lengths.size() &&
             rules_.crease_sharpnesses.size() != edges)
        fault = "there are neither as many creaseSharpnesses as creases nor as their edges";
    if (!fault.empty()) {
        contradictions_.push_back("all creases: " + fault);
        rules_.crease_indices.clear();
        rules_.crease_lengths.clear();
        rules_.crease_sharpnesses.clear();
    }
    if (rules_.corner_sharpnesses.size() != rules_.corner_indices.size()) {
        contradictions_.emplace_back(
            "all corners: there are not as many cornerSharpnesses as cornerIndices");
        rules_.corner_indices.clear();
        rules_.corner_sharpnesses.clear();
    }
    left_out_ = contradictions_;
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

Mesh Subdivider::refine(const Mesh& cage) {
    if (rules_.level == 0) return control_cage(cage, rules_);
    if (!known(cage)) {
        left_out_ = contradictions_;
        topology_ = refined_topology(cage, rules_, left_out_);
    }
    const RefinedTopology& topology = *topology_;
    const Far::TopologyLevel& last = topology.last();
    const RefinedTopology::Refiner refiner(*topology.refiner);
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
    if (rules_.name_elements) mesh.elements = topology.base_faces;
    return mesh;
}

Mesh subdivide(const Mesh& cage, const Subdivision& rules) {
    return Subdivider(rules).refine(cage);
}

}  // namespace irt
