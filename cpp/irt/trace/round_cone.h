// SPDX-License-Identifier: Apache-2.0
// The round cone: the convex hull of two balls, whatever their radii and however near; a segment of
// a curve, a capsule of two radii. Where one ball holds the other it is that ball.
#pragma once

#include "irt/scene/records.h"
#include "irt/trace/interval.h"

namespace irt::trace {

/// A ball in double.
struct ExactBall {
    V3d centre;
    double radius;

    ExactBall(const V3d& c, double r) : centre(c), radius(r) {}
    explicit ExactBall(const Ball& b) : centre(b.centre), radius(static_cast<double>(b.radius)) {}
};

/// A point of a solid's surface in shape space, and the gradient there: outward, of any length.
struct ShapePoint {
    V3d position, normal;
};

/// The stretch of o + t d inside `ball`: a pure function of these, so that segments which share a
/// ball agree on it. Piece 0; empty for a ball of radius 0.
[[nodiscard]] Interval inside_ball(const V3d& o, const V3d& d, const ExactBall& ball);

/// The stretch of the line inside the hull of `a` and `b`. Pieces: 0 side, 1 ball a, 2 ball b.
[[nodiscard]] Interval inside_round_cone(const Line& line, const ExactBall& a, const ExactBall& b);

/// `point`, near the surface, put on it.
[[nodiscard]] ShapePoint on_ball(const ExactBall& ball, const V3d& point);
[[nodiscard]] ShapePoint on_round_cone(const ExactBall& a, const ExactBall& b, std::uint8_t piece,
                                       const V3d& point);

}  // namespace irt::trace
