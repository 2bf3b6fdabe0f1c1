// SPDX-License-Identifier: Apache-2.0
// A mesh as a light: what a delta light needs to know to stand for it.
#pragma once

#include <string>
#include <vector>

#include "irt/scene/records.h"

namespace irt {

struct MeshLight {
    V3d centre{0, 0, 0};        ///< of its surface; world space
    double area = 0;            ///< world units
    std::vector<Facet> facets;  ///< faces of like normals are one
};

/// The front sides of `mesh` as they are placed. Throws std::invalid_argument, beginning with
/// `path`, on broken topology or values.
MeshLight make_mesh_light(const std::shared_ptr<const Mesh>& mesh, const M44d& world_from_object,
                          const std::string& path);

}  // namespace irt
