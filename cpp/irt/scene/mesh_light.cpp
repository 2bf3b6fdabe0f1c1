// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/mesh_light.h"

#include <array>
#include <cmath>
#include <map>

#include "irt/math/float_state.h"
#include "irt/scene/compile.h"

namespace irt {

namespace {

/// Normals are alike where their components round alike, in steps of so many to 1: about 400
/// directions in all, 11 degrees apart. What they sum up to is exact where all are seen.
constexpr double normal_steps = 5;

}  // namespace

MeshLight make_mesh_light(const std::shared_ptr<const Mesh>& mesh, const M44d& world_from_object,
                          const std::string& path) {
    const FloatState ieee;
    // The translation is left to the end: points are narrowed.
    M44d turned = world_from_object;
    for (int a = 0; a < 3; ++a) turned[3][a] = 0;
    const std::shared_ptr<const Triangles> cut = triangulate(mesh, turned, path);

    MeshLight light;
    struct Faces {
        V3d area{0, 0, 0}, centre{0, 0, 0};  ///< along their normals; summed up, times their sizes
        double size = 0;
    };
    std::map<std::array<long, 3>, Faces> alike;
    for (const auto& [a, b, c] : cut->triangles) {
        const V3d p(cut->points[a]), q(cut->points[b]), r(cut->points[c]);
        const V3d area = (q - p).cross(r - p) * 0.5;
        const double size = std::sqrt(area.dot(area));
        if (!(size > 0)) continue;
        std::array<long, 3> normal;
        for (int axis = 0; axis < 3; ++axis)
            normal[static_cast<std::size_t>(axis)] = std::lround(area[axis] / size * normal_steps);
        Faces& faces = alike[normal];
        faces.area += area;
        faces.centre += (p + q + r) * (size / 3);
        faces.size += size;
    }
    double turned_area = 0;
    for (const auto& [normal, faces] : alike) {
        light.area += faces.size;
        light.centre += faces.centre;
        turned_area += std::sqrt(faces.area.dot(faces.area));
    }
    if (light.area > 0) light.centre /= light.area;
    // What is lost where normals differ is given back, so that the power is that of the area.
    for (const auto& [normal, faces] : alike)
        light.facets.push_back({V3f(faces.area * (light.area / turned_area)),
                                V3f(faces.centre / faces.size - light.centre)});
    for (int a = 0; a < 3; ++a) light.centre[a] += world_from_object[3][a];
    return light;
}

}  // namespace irt
