// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/judge_many.h"

#include <algorithm>

#include "irt/trace/round_cone.h"

namespace irt::trace {
namespace {

Line shape_line(const M44d& shape_from_trace, const JudgeRay& ray) {
    const V3d o(ray.origin[0], ray.origin[1], ray.origin[2]);
    const V3d d(ray.direction[0], ray.direction[1], ray.direction[2]);
    return {transform_point(shape_from_trace, o), transform_direction(shape_from_trace, d)};
}

Interval inside_segment(const Curves& curves, std::uint32_t segment, const Line& line) {
    return inside_round_cone(line, ExactBall(curves.balls[segment]),
                             ExactBall(curves.balls[curves.next_ball(segment)]));
}

/// What is known of the stretch that a segment's own is part of.
struct Run {
    std::uint32_t segment;  ///< whose stretch `own` is
    Interval own;
    double first;                     ///< where the run is entered, as far as it was followed
    bool begins = true, ends = true;  ///< the run is entered, left in this segment

    /// Follows the run away from the segment along `step`; true if it came back to it.
    template <class Step>
    bool follow(const Curves& curves, const Line& line, Step&& step) {
        Interval last = own;
        for (std::uint32_t k = step(segment); k != Curves::none; k = step(k)) {
            if (k == segment) return true;
            const Interval in = inside_segment(curves, k, line);
            if (in.empty() || in.enter > last.exit || last.enter > in.exit) return false;
            first = std::min(first, in.enter);
            if (in.enter < own.enter || (in.enter == own.enter && k < segment)) begins = false;
            if (in.exit > own.exit || (in.exit == own.exit && k < segment)) ends = false;
            if (!begins && !ends) return false;
            last = in;
        }
        return false;
    }
};

}  // namespace

bool judge_ball(const Spheres& spheres, std::uint32_t primitive, const M44d& shape_from_trace,
                const JudgeRay& ray, SolidHit& hit) {
    const Line line = shape_line(shape_from_trace, ray);
    const Interval in = inside_ball(line.o, line.d, ExactBall(spheres.balls[primitive]));
    if (in.empty()) return false;
    hit = {in.enter > 0 ? in.enter : in.exit, 0};
    return hit.t > 0 && hit.t < ray.t_max;
}

bool judge_segment(const Curves& curves, std::uint32_t primitive, const M44d& shape_from_trace,
                   const JudgeRay& ray, SolidHit& hit) {
    if (curves.next_ball(primitive) == Curves::none) return false;
    const Line line = shape_line(shape_from_trace, ray);
    const Interval own = inside_segment(curves, primitive, line);
    if (own.empty() || !(own.exit > 0 && own.enter < ray.t_max)) return false;
    Run run{primitive, own, own.enter};
    const bool around = run.follow(curves, line, [&](auto k) { return curves.next_segment(k); });
    if (!around && (run.begins || run.ends))
        run.follow(curves, line, [&](auto k) { return curves.previous_segment(k); });
    if (run.first > 0 ? !run.begins : !run.ends) return false;
    hit = run.first > 0 ? SolidHit{own.enter, own.enter_piece} : SolidHit{own.exit, own.exit_piece};
    if (!(hit.t < ray.t_max)) return false;
    const V3d a(curves.balls[primitive].centre),
        along = V3d(curves.balls[curves.next_ball(primitive)].centre) - a;
    const double squared = along.dot(along);
    if (squared > 0)
        hit.u = std::clamp((point_at(line.o, line.d, hit.t) - a).dot(along) / squared, 0.0, 1.0);
    return true;
}

Box ball_box(const Ball& ball, const M44d& trace_from_shape) {
    Quadric sphere;
    sphere.radius = static_cast<double>(ball.radius);
    const V3d centre = transform_point(trace_from_shape, V3d(ball.centre)),
              half = quadric_half_extent(sphere, trace_from_shape);
    Box box;
    box.extend(centre - half);
    box.extend(centre + half);
    return box;
}

std::uint32_t primitive_count(const Surface& surface) {
    if (surface.triangles) return static_cast<std::uint32_t>(surface.triangles->triangles.size());
    if (surface.spheres) return static_cast<std::uint32_t>(surface.spheres->balls.size());
    if (surface.curves) return static_cast<std::uint32_t>(surface.curves->balls.size());
    return 1;
}

Box primitive_box(const Surface& surface, std::uint32_t primitive) {
    const M44d& m = surface.trace_from_shape;
    Box box;
    if (surface.spheres) {
        const Ball& ball = surface.spheres->balls[primitive];
        if (ball.radius > 0) box = ball_box(ball, m);
    } else if (surface.curves) {
        const std::uint32_t next = surface.curves->next_ball(primitive);
        if (next == Curves::none) return box;
        const Ball &a = surface.curves->balls[primitive], &b = surface.curves->balls[next];
        if (!(a.radius > 0 || b.radius > 0)) return box;
        box = ball_box(a, m);
        box.extend(ball_box(b, m));
    } else {
        const V3d centre = transform_point(m, V3d(0)),
                  half = quadric_half_extent(surface.quadric, m);
        box.extend(centre - half);
        box.extend(centre + half);
    }
    return box;
}

}  // namespace irt::trace
