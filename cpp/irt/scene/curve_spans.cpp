// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/curve_spans.h"

#include <algorithm>
#include <stdexcept>

namespace irt {

CurveWeights basis_weights(CurveBasis basis, double u) {
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

CurveWeights basis_slopes(CurveBasis basis, double u) {
    const double v = 1 - u, uu = u * u;
    switch (basis) {
        case CurveBasis::Bezier:
            return {-3 * v * v, 3 * v * v - 6 * u * v, 6 * u * v - 3 * uu, 3 * uu};
        case CurveBasis::BSpline:
            return {-v * v / 2, (3 * uu - 4 * u) / 2, (-3 * uu + 2 * u + 1) / 2, uu / 2};
        case CurveBasis::CatmullRom:
            return {(-3 * uu + 4 * u - 1) / 2, (9 * uu - 10 * u) / 2, (-9 * uu + 8 * u + 1) / 2,
                    (3 * uu - 2 * u) / 2};
        case CurveBasis::Linear:
            break;
    }
    return {-1, 1, 0, 0};
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
    const std::size_t normals = element_count(c, c.normals_interpolation);
    if (c.normals.size() != normals)
        throw std::invalid_argument("there are " + std::to_string(c.normals.size()) +
                                    " normals, expected " + std::to_string(normals));
}

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
        ends += CurveSpans{curves.basis, curves.wrap, static_cast<std::size_t>(count)}.ends();
    return ends;
}

}  // namespace irt
