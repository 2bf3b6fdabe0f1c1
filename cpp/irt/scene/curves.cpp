// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/curves.h"

#include <algorithm>
#include <stdexcept>

#include "irt/scene/curve_spans.h"

namespace irt {

std::shared_ptr<const Curves> make_curves(const ControlCurves& c, int segments) {
    check(c);
    const int steps = c.basis == CurveBasis::Linear ? 1 : segments;
    if (steps < 1) throw std::invalid_argument("a span needs at least one segment");
    auto out = std::make_shared<Curves>();
    out->closed = c.wrap == CurveWrap::Periodic;
    out->firsts.push_back(0);
    for (const Primvar& primvar : c.primvars) {
        Primvar& refined = out->primvars.emplace_back(primvar);
        if (!varies_along(primvar.interpolation)) continue;
        refined.interpolation = Interpolation::Vertex;
        refined.values.clear();
        refined.indices.clear();
    }
    CurveOffsets first;
    for (const std::int32_t count : c.vertex_counts) {
        const CurveSpans spans{c.basis, c.wrap, static_cast<std::size_t>(count)};
        const auto add = [&](std::size_t span, double u) {
            const V3d p = spans.value(
                span, u, [&](std::size_t i) { return V3d(c.points[first.vertex + i]); });
            const double width =
                value_at(spans, c.widths_interpolation, first, span, u,
                         [&](std::size_t i) { return static_cast<double>(c.widths[i]); });
            for (std::size_t k = 0; k < c.primvars.size(); ++k)
                if (varies_along(c.primvars[k].interpolation))
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
