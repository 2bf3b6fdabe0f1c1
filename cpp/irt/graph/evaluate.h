// SPDX-License-Identifier: Apache-2.0
// Materials at a point of a surface. Pure functions of records, hit and footprint.
#pragma once

#include <optional>
#include <string_view>

#include "irt/graph/value.h"
#include "irt/scene/scene.h"
#include "irt/trace/ray.h"

namespace irt::graph {

/// Where a point lies: what nodes that ask for positions, normals or spaces read.
struct Place {
    M44d world_from_object, object_from_world;  ///< object: the space that the shape is authored in
    V3d position, normal;                       ///< object space; the normal is of unit length
    V3d along, across;                          ///< object space: the axes of the ray's footprint
    V3d view;                                   ///< object space, unit: the way of the ray

    /// `position`, `normal` (unit, outward), `view`, `along` and `across` are in render space.
    Place(const Scene& scene, const trace::Hit& hit, const V3d& position_render,
          const V3d& normal_render, const V3d& view_render, const V3d& along_render,
          const V3d& across_render);
};

/// Where on a surface, and how far the triangle's weights change along the axes of the ray's
/// footprint; all 0: the footprint is a point.
struct Site {
    const Scene& scene;
    const Surface& surface;
    const trace::Hit& hit;
    double u_x = 0, v_x = 0, u_y = 0, v_y = 0;
    const Place* place = nullptr;  ///< given where reads_place
};

/// A primvar's value: of the mesh, points or curves, else a constant one of the object or part,
/// else of the instance. Empty where there is none.
[[nodiscard]] std::optional<Value> primvar_value(const Site& site, std::string_view name);

/// All inputs of `material` at `site`, brought within the specification's ranges.
[[nodiscard]] SurfaceValues evaluate(const Material& material, const Site& site);

/// What a shadow ray loses at `site`, a material whose tint varies.
[[nodiscard]] trace::OpticalDepth tint_at(const MaterialSlot& material, const Site& site);

}  // namespace irt::graph
