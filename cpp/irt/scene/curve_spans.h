// SPDX-License-Identifier: Apache-2.0
// Curves span by span: what tubes and ribbons are made from.
#pragma once

#include <array>
#include <cstddef>

#include "irt/scene/curves.h"

namespace irt {

using CurveWeights = std::array<double, 4>;

/// The weights of a span's four control points at u in [0, 1], and their derivatives by u.
[[nodiscard]] CurveWeights basis_weights(CurveBasis basis, double u);
[[nodiscard]] CurveWeights basis_slopes(CurveBasis basis, double u);

/// Of one curve: its spans, and which control points and span ends they read.
struct CurveSpans {
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

    /// The value at `u` within span `span` of what `at` gives by vertex, and its derivative by u.
    template <class At>
    [[nodiscard]] auto value(std::size_t span, double u, At&& at) const {
        return weighted(span, basis_weights(basis, u), at);
    }
    template <class At>
    [[nodiscard]] auto slope(std::size_t span, double u, At&& at) const {
        return weighted(span, basis_slopes(basis, u), at);
    }

  private:
    template <class At>
    [[nodiscard]] auto weighted(std::size_t span, const CurveWeights& weights, At&& at) const {
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
struct CurveOffsets {
    std::size_t curve = 0, vertex = 0, end = 0;
};

/// What `at` gives by element, at `u` within a span.
template <class At>
auto value_at(const CurveSpans& spans, Interpolation interpolation, const CurveOffsets& first,
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

/// Whether values of this interpolation change along a curve.
[[nodiscard]] inline bool varies_along(Interpolation interpolation) {
    return interpolation == Interpolation::Vertex || interpolation == Interpolation::Varying ||
           interpolation == Interpolation::FaceVarying;
}

/// Appends a control primvar's value at `u` within a span to `refined`.
inline void add_value(const Primvar& primvar, const CurveSpans& spans, const CurveOffsets& first,
                      std::size_t span, double u, Primvar& refined) {
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

/// Throws std::invalid_argument on counts that do not fit.
void check(const ControlCurves& curves);

}  // namespace irt
