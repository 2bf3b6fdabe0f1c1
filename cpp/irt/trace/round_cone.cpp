// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/round_cone.h"

namespace irt::trace {
namespace {

/// The cone that touches both balls, seen from the middle of their centres: a point z along `axis`
/// and p across it is inside where cosine |p| <= radius - sine z. (Times the cosine, lest a cone be
/// steep that is nearly a plane, where one ball almost holds the other.)
struct TangentCone {
    V3d middle, axis;
    double low, high;  ///< along the axis: where the cone touches ball a and ball b
    double radius, sine, cosine;

    /// False where one ball holds the other, and there is none.
    bool set(const ExactBall& a, const ExactBall& b) {
        const V3d along = b.centre - a.centre;
        const double length = std::sqrt(along.dot(along)), fall = a.radius - b.radius;
        if (!(std::fabs(fall) < length)) return false;
        middle = a.centre * 0.5 + b.centre * 0.5;
        axis = along / length;
        sine = fall / length;
        cosine = std::sqrt((1 - sine) * (1 + sine));
        low = a.radius * sine - length / 2;
        high = b.radius * sine + length / 2;
        radius = (a.radius + b.radius) / 2;
        return true;
    }
};

/// The part of the hull between the circles in which its cone touches the balls.
Interval inside_cone(const TangentCone& cone, const Line& line) {
    Interval in;
    const double start = nearest_parameter(line.o, line.d, cone.middle);
    const V3d o = point_at(line.o, line.d, start) - cone.middle;
    const double z = o.dot(cone.axis), dz = line.d.dot(cone.axis);
    if (dz == 0) {
        if (!(z >= cone.low && z <= cone.high)) in.clear();
    } else {
        const auto [a, b] = divided(cone.low - z, cone.high - z, dz);
        if (dz > 0)
            in.clip(a, 1, b, 2);
        else
            in.clip(b, 2, a, 1);
    }
    clip_nappe(in, (o - cone.axis * z) * cone.cosine, (line.d - cone.axis * dz) * cone.cosine,
               cone.radius - cone.sine * z, -cone.sine * dz, 0);
    in.shift(start);
    return in;
}

}  // namespace

Interval inside_ball(const V3d& o, const V3d& d, const ExactBall& ball) {
    Interval in;
    if (!(ball.radius > 0)) {
        in.clear();
        return in;
    }
    const double start = nearest_parameter(o, d, ball.centre);
    clip_ball(in, {point_at(o, d, start), d}, ball.centre, ball.radius, 0);
    in.shift(start);
    return in;
}

Interval inside_round_cone(const Line& line, const ExactBall& a, const ExactBall& b) {
    const auto ball = [&](const ExactBall& of, std::uint8_t piece) {
        Interval in = inside_ball(line.o, line.d, of);
        in.enter_piece = in.exit_piece = piece;
        return in;
    };
    TangentCone cone;
    if (!cone.set(a, b)) return a.radius > b.radius ? ball(a, 1) : ball(b, 2);
    // The cone's flat ends lie within the balls; where rounding makes one bind, it is the ball.
    Interval in = inside_cone(cone, line);
    in.unite(ball(a, 1));
    in.unite(ball(b, 2));
    return in;
}

ShapePoint on_ball(const ExactBall& ball, const V3d& point) {
    V3d n = point - ball.centre;
    const double length = n.length();
    n = length > 0 ? n / length : V3d(0, 0, 1);
    return {ball.centre + n * ball.radius, n};
}

ShapePoint on_round_cone(const ExactBall& a, const ExactBall& b, std::uint8_t piece,
                         const V3d& point) {
    TangentCone cone;
    if (piece != 0 || !cone.set(a, b)) return on_ball(piece == 2 ? b : a, point);
    const V3d o = point - cone.middle;
    const double z = o.dot(cone.axis);
    const V3d across = o - cone.axis * z;
    const double distance = across.length();
    if (!(distance > 0)) return {point, cone.axis * (cone.sine < 0 ? -1.0 : 1.0)};
    const V3d n = across * (cone.cosine / distance) + cone.axis * cone.sine;
    return {point - n * (cone.cosine * distance + cone.sine * z - cone.radius), n};
}

}  // namespace irt::trace
