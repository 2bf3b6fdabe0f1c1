// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/curves.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace irt {

namespace {

using Weights = std::array<double, 4>;

/// The weights of a span's four control points at u in [0, 1].
Weights basis_weights(CurveBasis basis, double u) {
    const double v = 1 - u, uu = u * u, uuu = uu * u;
    switch (basis) {
        case CurveBasis::Bezier:
            return {v * v * v, 3 * u * v * v, 3 * uu * v, uuu};
        case CurveBasis::BSpline:
            return {v * v * v / 6, (3 * uuu - 6 * uu + 4) / 6, (-3 * uuu + 3 * uu + 3 * u + 1) / 6,
                    uuu / 6};
        case CurveBasis::CatmullRom:
            return {(-uuu + 2 * uu - u) / 2, (3 * uuu - 5 * uu + 2) / 2,
                    (-3 * uuu + 4 * uu + u) / 2, (uuu - uu) / 2};
        case CurveBasis::Linear:
            break;
    }
    return {v, u, 0, 0};
}

/// Of one curve: its spans, and which control points and span ends they read.
struct Spans {
    CurveBasis basis;
    CurveWrap wrap;
    std::size_t vertices;

    /// Vertices from one span to the next.
    [[nodiscard]] std::size_t step() const { return basis == CurveBasis::Bezier ? 3 : 1; }
    [[nodiscard]] bool closed() const { return wrap == CurveWrap::Periodic; }
    /// Whether a pinned curve has another point before its first and after its last.
    [[nodiscard]] bool extended() const {
        return wrap == CurveWrap::Pinned &&
               (basis == CurveBasis::BSpline || basis == CurveBasis::CatmullRom);
    }
    [[nodiscard]] std::size_t count() const {
        if (closed()) return vertices / step();
        if (basis == CurveBasis::Linear || extended()) return vertices - 1;
        return (vertices - 4) / step() + 1;
    }
    [[nodiscard]] std::size_t ends() const { return closed() ? count() : count() + 1; }

    /// The value at `u` within span `span` of what `at` gives by vertex.
    template <class At>
    [[nodiscard]] auto value(std::size_t span, double u, At&& at) const {
        const Weights weights = basis_weights(basis, u);
        const auto control = [&](std::size_t k) {
            // Shifted by one vertex where the curve is extended: its first point is not authored.
            const std::size_t i = span * step() + k;
            if (!extended()) return at(i % vertices);
            if (i == 0) return at(0) * 2.0 - at(1);
            if (i > vertices) return at(vertices - 1) * 2.0 - at(vertices - 2);
            return at(i - 1);
        };
        auto sum = control(0) * weights[0] + control(1) * weights[1];
        if (basis != CurveBasis::Linear) sum += control(2) * weights[2] + control(3) * weights[3];
        return sum;
    }
};

/// Places in the input where each curve's values begin.
struct Offsets {
    std::size_t curve = 0, vertex = 0, end = 0;
};

/// What `at` gives by element, at `u` within a span.
template <class At>
auto value_at(const Spans& spans, Interpolation interpolation, const Offsets& first,
              std::size_t span, double u, At&& at) {
    switch (interpolation) {
        case Interpolation::None:
        case Interpolation::Constant:
            break;
        case Interpolation::Uniform:
            return at(first.curve);
        case Interpolation::Vertex:
            return spans.value(span, u, [&](std::size_t i) { return at(first.vertex + i); });
        case Interpolation::Varying:
        case Interpolation::FaceVarying:
            return at(first.end + span) * (1 - u) + at(first.end + (span + 1) % spans.ends()) * u;
    }
    return at(0);
}

bool by_ball(Interpolation interpolation) {
    return interpolation == Interpolation::Vertex || interpolation == Interpolation::Varying ||
           interpolation == Interpolation::FaceVarying;
}

/// Appends a control primvar's value at `u` within a span to that of a ball.
void add_value(const Primvar& primvar, const Spans& spans, const Offsets& first, std::size_t span,
               double u, Primvar& refined) {
    const auto width = static_cast<std::size_t>(primvar.width);
    for (std::size_t component = 0; component < width; ++component) {
        const auto at = [&](std::size_t i) {
            if (!primvar.indices.empty()) i = static_cast<std::size_t>(primvar.indices[i]);
            return static_cast<double>(primvar.values[i * width + component]);
        };
        refined.values.push_back(
            static_cast<float>(value_at(spans, primvar.interpolation, first, span, u, at)));
    }
}

void check(const ControlCurves& c) {
    std::size_t vertices = 0;
    for (const std::int32_t count : c.vertex_counts) {
        const std::string fault = vertex_count_fault(c.basis, c.wrap, count);
        if (!fault.empty())
            throw std::invalid_argument("a curve has " + std::to_string(count) +
                                        " vertices; they must " + fault);
        vertices += static_cast<std::size_t>(count);
    }
    if (vertices != c.points.size())
        throw std::invalid_argument("the sum of the vertex counts is " + std::to_string(vertices) +
                                    ", but there are " + std::to_string(c.points.size()) +
                                    " points");
    for (const Primvar& primvar : c.primvars) {
        const auto values =
            primvar.values.size() / static_cast<std::size_t>(std::max(primvar.width, 1));
        const auto in_range = [&](std::int32_t i) {
            return i >= 0 && static_cast<std::size_t>(i) < values;
        };
        if ((primvar.indices.empty() ? values : primvar.indices.size()) !=
                element_count(c, primvar.interpolation) ||
            !std::all_of(primvar.indices.begin(), primvar.indices.end(), in_range))
            throw std::invalid_argument("primvar " + primvar.name +
                                        " has not as many elements as the curves ask for");
    }
    const std::size_t widths = element_count(c, c.widths_interpolation);
    if (c.widths.size() != widths)
        throw std::invalid_argument("there are " + std::to_string(c.widths.size()) +
                                    " widths, expected " + std::to_string(widths));
}

}  // namespace

std::string vertex_count_fault(CurveBasis basis, CurveWrap wrap, std::int32_t vertices) {
    const bool closed = wrap == CurveWrap::Periodic;
    if (basis == CurveBasis::Bezier) {
        if (closed) return vertices >= 3 && vertices % 3 == 0 ? "" : "be 3, 6, 9 or so on";
        return vertices >= 4 && vertices % 3 == 1 ? "" : "be 4, 7, 10 or so on";
    }
    const bool two = basis == CurveBasis::Linear || wrap == CurveWrap::Pinned;
    const std::int32_t least = closed ? 3 : two ? 2 : 4;
    return vertices >= least ? "" : "be " + std::to_string(least) + " or more";
}

std::size_t element_count(const ControlCurves& curves, Interpolation interpolation) {
    switch (interpolation) {
        case Interpolation::None:
            return 0;
        case Interpolation::Constant:
            return 1;
        case Interpolation::Uniform:
            return curves.vertex_counts.size();
        case Interpolation::Vertex:
            return curves.points.size();
        case Interpolation::Varying:
        case Interpolation::FaceVarying:
            break;
    }
    std::size_t ends = 0;
    for (const std::int32_t count : curves.vertex_counts)
        ends += Spans{curves.basis, curves.wrap, static_cast<std::size_t>(count)}.ends();
    return ends;
}

std::shared_ptr<const Curves> make_curves(const ControlCurves& c, int segments) {
    check(c);
    const int steps = c.basis == CurveBasis::Linear ? 1 : segments;
    if (steps < 1) throw std::invalid_argument("a span needs at least one segment");
    auto out = std::make_shared<Curves>();
    out->closed = c.wrap == CurveWrap::Periodic;
    out->firsts.push_back(0);
    for (const Primvar& primvar : c.primvars) {
        Primvar& refined = out->primvars.emplace_back(primvar);
        if (!by_ball(primvar.interpolation)) continue;
        refined.interpolation = Interpolation::Vertex;
        refined.values.clear();
        refined.indices.clear();
    }
    Offsets first;
    for (const std::int32_t count : c.vertex_counts) {
        const Spans spans{c.basis, c.wrap, static_cast<std::size_t>(count)};
        const auto add = [&](std::size_t span, double u) {
            const V3d p = spans.value(
                span, u, [&](std::size_t i) { return V3d(c.points[first.vertex + i]); });
            const double width =
                value_at(spans, c.widths_interpolation, first, span, u,
                         [&](std::size_t i) { return static_cast<double>(c.widths[i]); });
            for (std::size_t k = 0; k < c.primvars.size(); ++k)
                if (by_ball(c.primvars[k].interpolation))
                    add_value(c.primvars[k], spans, first, span, u, out->primvars[k]);
            out->balls.push_back({V3f(p), static_cast<float>(std::max(width, 0.0) / 2)});
        };
        for (std::size_t span = 0; span < spans.count(); ++span)
            for (int i = 0; i < steps; ++i) add(span, static_cast<double>(i) / steps);
        if (!out->closed) add(spans.count() - 1, 1);
        out->curve_of.resize(out->balls.size(), static_cast<std::uint32_t>(first.curve));
        out->firsts.push_back(static_cast<std::uint32_t>(out->balls.size()));
        ++first.curve;
        first.vertex += spans.vertices;
        first.end += spans.ends();
    }
    return out;
}

}  // namespace irt
