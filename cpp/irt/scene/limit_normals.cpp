// SPDX-License-Identifier: Apache-2.0
// Normals of the limit surface, apart on the sides of what is sharp.
#include <algorithm>
#include <cmath>

#include "irt/scene/refined_topology.h"

namespace irt {

namespace {

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

}  // namespace

void RefinedTopology::set_normals(const Values& limits, const Values& first, const Values& second,
                                  Mesh& mesh) const {
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

}  // namespace irt
