// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes.
#pragma once

#include <algorithm>
#include <utility>

#include "irt/math/vec.h"

namespace irt::trace {

struct Box {
    V3d lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};

    void extend(const V3d& p) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = std::min(lower[a], p[a]);
            upper[a] = std::max(upper[a], p[a]);
        }
    }
    void extend(const Box& b) {
        extend(b.lower);
        extend(b.upper);
    }
    [[nodiscard]] bool empty() const { return !(lower.x <= upper.x); }
};

/// The box of `box`, which is not empty, under the affine `a_from_b`.
inline Box transformed(const Box& box, const M44d& a_from_b) {
    Box out;
    for (int corner = 0; corner < 8; ++corner)
        out.extend(transform_point(a_from_b, {(corner & 1 ? box.upper : box.lower).x,
                                              (corner & 2 ? box.upper : box.lower).y,
                                              (corner & 4 ? box.upper : box.lower).z}));
    return out;
}

/// Narrows the stretch [enter, exit] of a line to where it is within `box`; false if it is nowhere.
/// Rounds to a few ulp of the line's parameter; callers allow for it.
inline bool clip(const Box& box, const V3d& origin, const V3d& direction, double& enter,
                 double& exit) {
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) {
            if (origin[a] < box.lower[a] || origin[a] > box.upper[a]) return false;
            continue;
        }
        const double inverse = 1 / direction[a];
        double t0 = (box.lower[a] - origin[a]) * inverse, t1 = (box.upper[a] - origin[a]) * inverse;
        if (t0 > t1) std::swap(t0, t1);
        enter = std::max(enter, t0);
        exit = std::min(exit, t1);
    }
    return enter <= exit;
}

}  // namespace irt::trace
