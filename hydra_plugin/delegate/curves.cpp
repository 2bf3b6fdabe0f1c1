// SPDX-License-Identifier: Apache-2.0
#include "delegate/curves.h"

#include <algorithm>
#include <stdexcept>

#include "delegate/convert.h"
#include "delegate/pointBased.h"
#include "irt/scene/curves.h"
#include "pxr/imaging/hd/basisCurvesTopology.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Straight pieces of a cubic span at refine level 0; each level doubles them.
constexpr int segmentsAtLevel0 = 8;

irt::CurveBasis Basis(const HdBasisCurvesTopology& topology) {
    if (topology.GetCurveType() == HdTokens->linear) return irt::CurveBasis::Linear;
    const TfToken basis = topology.GetCurveBasis();
    if (basis == HdTokens->bspline || basis == HdTokens->bSpline) return irt::CurveBasis::BSpline;
    if (basis == HdTokens->catmullRom) return irt::CurveBasis::CatmullRom;
    return irt::CurveBasis::Bezier;
}

irt::CurveWrap Wrap(const HdBasisCurvesTopology& topology) {
    if (topology.GetCurveWrap() == HdTokens->periodic) return irt::CurveWrap::Periodic;
    if (topology.GetCurveWrap() == HdTokens->pinned) return irt::CurveWrap::Pinned;
    return irt::CurveWrap::Nonperiodic;
}

/// The core has varying values, one at each end of a span, as face-varying ones.
irt::Interpolation AtEnds(irt::Interpolation interpolation) {
    return interpolation == irt::Interpolation::Varying ? irt::Interpolation::FaceVarying
                                                        : interpolation;
}

}  // namespace

bool HdIrtCurves::_ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                                HdIrtShape& shape) {
    const HdBasisCurvesTopology topology = delegate.GetBasisCurvesTopology(GetId());
    std::optional<std::vector<irt::V3f>> points = HdIrtReadPoints(delegate, GetId());
    if (!points || topology.GetCurveVertexCounts().empty()) return false;
    if (topology.HasIndices()) {
        TF_WARN("<%s>: curves with indices are not drawn", GetId().GetText());
        return false;
    }
    irt::ControlCurves control;
    control.basis = Basis(topology);
    control.wrap = Wrap(topology);
    control.points = std::move(*points);
    control.vertex_counts = HdIrtArray(topology.GetCurveVertexCounts());
    try {
        std::int64_t total = 0;
        for (const int count : control.vertex_counts) {
            const std::string fault = irt::vertex_count_fault(control.basis, control.wrap, count);
            if (!fault.empty()) throw std::invalid_argument("a curve's vertices must " + fault);
            total += count;
        }
        if (total != static_cast<std::int64_t>(control.points.size()))
            throw std::invalid_argument("the vertex counts sum to " + std::to_string(total) +
                                        ", but there are " + std::to_string(control.points.size()) +
                                        " points");
        const auto count = [&](irt::Interpolation interpolation) {
            return irt::element_count(control, AtEnds(interpolation));
        };
        std::optional<HdIrtWidths> widths = HdIrtReadWidths(delegate, GetId(), count);
        if (!widths) return false;
        control.widths = std::move(widths->values);
        control.widths_interpolation = AtEnds(widths->interpolation);
        control.primvars = HdIrtReadPrimvars(delegate, GetId(), wanted, count);
        for (irt::Primvar& primvar : control.primvars)
            primvar.interpolation = AtEnds(primvar.interpolation);
        const int level = std::clamp(delegate.GetDisplayStyle(GetId()).refineLevel, 0, 8);
        shape.geometry = irt::make_curves(control, segmentsAtLevel0 << level);
    } catch (const std::invalid_argument& error) {
        TF_WARN("<%s>: %s; it is not drawn", GetId().GetText(), error.what());
        return false;
    }
    return true;
}

PXR_NAMESPACE_CLOSE_SCOPE
