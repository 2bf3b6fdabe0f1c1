// SPDX-License-Identifier: Apache-2.0
// UsdGeomBasisCurves' control points to the polylines that are traced: done here once, for every
// front end alike, uniformly and by topology alone (DESIGN 2).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "irt/scene/records.h"

namespace irt {

enum class CurveBasis : std::uint8_t { Linear, Bezier, BSpline, CatmullRom };
enum class CurveWrap : std::uint8_t { Nonperiodic, Periodic, Pinned };

/// Curves as authored. Interpolations are UsdGeom's; FaceVarying stands for varying, a value at
/// each end of a span.
struct ControlCurves {
    CurveBasis basis = CurveBasis::Linear;
    CurveWrap wrap = CurveWrap::Nonperiodic;
    std::vector<V3f> points;
    std::vector<std::int32_t> vertex_counts;
    std::vector<float> widths;  ///< diameters
    Interpolation widths_interpolation = Interpolation::Constant;
    std::vector<V3f> normals = {};  ///< of ribbons; empty: tubes
    Interpolation normals_interpolation = Interpolation::None;
    Primvars primvars = {};
};

/// Why a curve of so many vertices has no spans of this basis and wrap, in words that follow "a
/// curve's vertices must"; empty where it has.
std::string vertex_count_fault(CurveBasis basis, CurveWrap wrap, std::int32_t vertices);

/// The values that `interpolation` asks for, as UsdGeomPrimvar defines it for curves.
std::size_t element_count(const ControlCurves& curves, Interpolation interpolation);

/// The curves as chains of balls: control points, or of cubics each span at `segments` equal steps
/// of its parameter, evaluated in double and narrowed once. Between two balls the chain leaves the
/// curve by at most |P''| / (8 segments^2), P'' being the span's second derivative by its parameter
/// (0 to 1) where it is largest. Widths that a cubic takes below 0 are 0.
/// Throws std::invalid_argument on counts that do not fit.
std::shared_ptr<const Curves> make_curves(const ControlCurves& curves, int segments);

}  // namespace irt
