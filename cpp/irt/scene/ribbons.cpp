// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/ribbons.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "irt/scene/curve_spans.h"

namespace irt {

namespace {

/// How much farther than half the width a ribbon reaches where it bends.
constexpr double most_miter = 2;

V3d unit(const V3d& v) {
    const double length = v.length();
    return length > 0 && std::isfinite(length) ? v / length : V3d(0);
}

bool is_zero(const V3d& v) { return v == V3d(0, 0, 0); }

/// A place along a curve: the span that it is in, and where within.
struct Place {
    std::size_t span;
    double u;
};

/// The direction from a ribbon's middle to its edge where its sides run along `before` and `after`,
/// as long as keeps its width 2 on both sides; zero where there is none.
V3d across(const V3d& before, const V3d& after, const V3d& normal) {
    const V3d a = unit(before.cross(normal)), b = unit(after.cross(normal));
    if (is_zero(a)) return b;
    if (is_zero(b)) return a;
    const V3d mean = unit(a + b);
    if (is_zero(mean)) return a;
    return mean * std::min(1 / mean.dot(a), most_miter);
}

}  // namespace

std::shared_ptr<const Mesh> make_ribbons(const ControlCurves& c, int segments) {
    check(c);
    const int steps = c.basis == CurveBasis::Linear ? 1 : segments;
    if (steps < 1) throw std::invalid_argument("a span needs at least one segment");
    auto out = std::make_shared<Mesh>();
    out->normals_interpolation = Interpolation::Vertex;
    for (const Primvar& primvar : c.primvars) {
        Primvar& refined = out->primvars.emplace_back(primvar);
        if (primvar.interpolation == Interpolation::Uniform) refined.indices.clear();
        if (!varies_along(primvar.interpolation)) continue;
        refined.interpolation = Interpolation::Vertex;
        refined.values.clear();
        refined.indices.clear();
    }
    CurveOffsets first;
    for (const std::int32_t count : c.vertex_counts) {
        const CurveSpans spans{c.basis, c.wrap, static_cast<std::size_t>(count)};
        const auto point = [&](std::size_t i) { return V3d(c.points[first.vertex + i]); };
        const auto tangent = [&](const Place& at) {
            const V3d slope = unit(spans.slope(at.span, at.u, point));
            if (!is_zero(slope)) return slope;
            // The curve halts: its direction is that to what is next to it.
            const double near = 1.0 / steps;
            const bool end = at.u > 0.5;
            return unit(spans.value(at.span, end ? at.u : near, point) -
                        spans.value(at.span, end ? at.u - near : 0.0, point));
        };
        const std::size_t pieces = spans.count() * static_cast<std::size_t>(steps);
        const std::size_t places = spans.closed() ? pieces : pieces + 1;
        const auto base = static_cast<std::int32_t>(out->points.size());
        V3d side(0);
        for (std::size_t i = 0; i < places; ++i) {
            const auto per_span = static_cast<std::size_t>(steps);
            const bool joint = i % per_span == 0, last = i == pieces;
            const Place at = last ? Place{spans.count() - 1, 1.0}
                                  : Place{i / per_span, static_cast<double>(i % per_span) / steps};
            V3d after = tangent(at), before = after;
            if (joint && !last && (i > 0 || spans.closed()))
                before = tangent({(at.span + spans.count() - 1) % spans.count(), 1.0});
            const V3d normal = unit(value_at(spans, c.normals_interpolation, first, at.span, at.u,
                                             [&](std::size_t k) { return V3d(c.normals[k]); }));
            const V3d next = across(before, after, normal);
            if (!is_zero(next)) side = next;
            const double width =
                value_at(spans, c.widths_interpolation, first, at.span, at.u,
                         [&](std::size_t k) { return static_cast<double>(c.widths[k]); });
            const V3d middle = spans.value(at.span, at.u, point),
                      half = side * (std::max(width, 0.0) / 2);
            for (const V3d& edge : {middle - half, middle + half}) {
                out->points.emplace_back(V3f(edge));
                out->normals.emplace_back(V3f(normal));
                for (std::size_t k = 0; k < c.primvars.size(); ++k)
                    if (varies_along(c.primvars[k].interpolation))
                        add_value(c.primvars[k], spans, first, at.span, at.u, out->primvars[k]);
            }
        }
        for (std::size_t i = 0; i < pieces; ++i) {
            const auto here = base + 2 * static_cast<std::int32_t>(i);
            const auto there = base + 2 * static_cast<std::int32_t>((i + 1) % places);
            out->face_vertex_counts.push_back(4);
            out->elements.push_back(static_cast<std::int32_t>(first.curve));
            for (const std::int32_t vertex : {here, here + 1, there + 1, there})
                out->face_vertex_indices.push_back(vertex);
            for (std::size_t k = 0; k < c.primvars.size(); ++k) {
                if (c.primvars[k].interpolation != Interpolation::Uniform) continue;
                const std::vector<std::int32_t>& named = c.primvars[k].indices;
                out->primvars[k].indices.push_back(
                    named.empty() ? static_cast<std::int32_t>(first.curve) : named[first.curve]);
            }
        }
        ++first.curve;
        first.vertex += spans.vertices;
        first.end += spans.ends();
    }
    return out;
}

}  // namespace irt
