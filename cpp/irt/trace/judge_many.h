// SPDX-License-Identifier: Apache-2.0
// Ray against one primitive of a shape that has many: a ball, or a segment of a curve.
#pragma once

#include "irt/scene/scene.h"
#include "irt/trace/box.h"
#include "irt/trace/judge_quadric.h"

namespace irt::trace {

/// Whether the ray meets ball `primitive` with 0 < t < ray.t_max, entering or else leaving. `ray`
/// is in trace space.
[[nodiscard]] bool judge_ball(const Spheres& spheres, std::uint32_t primitive,
                              const M44d& shape_from_trace, const JudgeRay& ray, SolidHit& hit);

/// Whether the ray meets segment `primitive`.
///
/// The balls at the joints make neighbouring segments overlap; within the curve there is no
/// surface. So the stretches inside consecutive segments that overlap along the ray are one: it
/// begins in the segment that is entered first, and the ray meets that one and no other; a ray that
/// starts within meets the one it leaves last (of several alike the lowest). A shadow ray is thus
/// tinted once for each time it goes through the curve, and since each stretch is a pure function
/// of ray and segment, nothing leaks between two. Segments that are not neighbours do not know of
/// each other, as two curves do not.
[[nodiscard]] bool judge_segment(const Curves& curves, std::uint32_t primitive,
                                 const M44d& shape_from_trace, const JudgeRay& ray, SolidHit& hit);

/// The box of `ball` under `trace_from_shape`.
[[nodiscard]] Box ball_box(const Ball& ball, const M44d& trace_from_shape);

/// Primitives of a surface; numbers below this that no primitive has meet nothing.
[[nodiscard]] std::uint32_t primitive_count(const Surface& surface);

/// The box of a primitive of a surface that is no mesh, in trace space; empty where there is none.
[[nodiscard]] Box primitive_box(const Surface& surface, std::uint32_t primitive);

}  // namespace irt::trace
