// SPDX-License-Identifier: Apache-2.0
// Ray against the exact solids of UsdGeom, in double. Every solid is convex, so the ray is inside
// it for one interval of t, had by intersecting (a capsule: uniting) the intervals of simple
// bodies; side and cap cannot leave a gap between them, whatever is rounded.
#pragma once

#include <cstdint>

#include "irt/math/vec.h"
#include "irt/scene/records.h"
#include "irt/trace/judge_ray.h"
#include "irt/trace/round_cone.h"

namespace irt::trace {

/// Hit::piece: which surface of the solid was met.
///   Sphere: 0. Plane: 0. Cube: 2 * axis + (1 if the positive face).
///   Cylinder: 0 side, 1 cap at -height/2, 2 cap at +height/2.
///   Cone: 0 side, 1 base. Capsule: 0 side, 1 sphere at -height/2, 2 sphere at +height/2.
///   Frustum as Cylinder, RoundCone as Capsule.
struct SolidHit {
    double t;
    std::uint8_t piece;
    double u = 0;  ///< of a segment: how far along its axis, 0 to 1
};

/// The first crossing of the surface with 0 < t < ray.t_max, entering or else leaving. `ray` is in
/// trace space. A degenerate solid (a length that is zero, negative or NaN) is never hit.
[[nodiscard]] bool judge_quadric(const Quadric& quadric, const M44d& shape_from_trace,
                                 const JudgeRay& ray, SolidHit& hit);

/// Where `point` (shape space, near the surface) lies on `piece` exactly, and the gradient there
/// (outward, not of unit length). A plane's outward is +z.
[[nodiscard]] ShapePoint on_quadric(const Quadric& quadric, std::uint8_t piece, const V3d& point);

/// Half the extent of the solid's box in trace space, about the image of the shape's origin.
[[nodiscard]] V3d quadric_half_extent(const Quadric& quadric, const M44d& trace_from_shape);

}  // namespace irt::trace
