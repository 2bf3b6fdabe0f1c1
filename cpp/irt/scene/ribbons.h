// SPDX-License-Identifier: Apache-2.0
// Curves with normals: flat ribbons across them (UsdGeomBasisCurves), as meshes.
#pragma once

#include <memory>

#include "irt/scene/curves.h"

namespace irt {

/// `curves` as strips of quadrilaterals: control points, or of cubics each span at `segments` equal
/// steps of its parameter, evaluated in double and narrowed once. A strip's edges lie on the curve
/// plus and minus half its width along tangent x normal. Neighbouring quadrilaterals share their
/// points, so that a strip has no gaps: where the curve bends at a point, they meet along the mean
/// of both directions, as far out as keeps the width, at most twice as far. Normals are the
/// interpolated ones.
/// Throws std::invalid_argument on counts that do not fit.
std::shared_ptr<const Mesh> make_ribbons(const ControlCurves& curves, int segments);

}  // namespace irt
