// SPDX-License-Identifier: Apache-2.0
// Polygons into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "irt/scene/records.h"

namespace irt {

/// The triangles of a face whose corners are `first` to `first + count - 1` of
/// mesh.face_vertex_indices, as corner numbers, wound as the face. A convex face is fanned from its
/// first corner; a concave one is clipped ear by ear (Meisters, "Polygons have ears", Amer. Math.
/// Monthly 82, 1975) as seen along its normal by Newell's method. Faces of fewer than three corners
/// give none. Depends on the authored positions alone.
std::vector<std::array<std::uint32_t, 3>> triangulate_polygon(const Mesh& mesh, std::uint32_t first,
                                                              std::uint32_t count);

}  // namespace irt
