// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/shadow_rule.h"

#include <algorithm>
#include <cmath>

#include "irt/math/libm.h"

namespace irt::trace {

OpticalDepth ShadowRule::faded(const OpticalDepth& depth, double from_point) const {
    if (from_point <= distance - falloff) return depth;
    const double strength =
        libm::pow(std::clamp((distance - from_point) / falloff, 0.0, 1.0), gamma);
    OpticalDepth left;
    for (int c = 0; c < 3; ++c) {
        const double passed =
            depth.rgb[c] >= depth_opaque ? 0 : libm::exp2(-(depth.rgb[c] / depth_scale));
        const double steps = std::round(-depth_scale * libm::log2(1 - strength * (1 - passed)));
        left.rgb[c] = steps < depth_opaque ? static_cast<std::uint32_t>(steps) : depth_opaque;
    }
    return left;
}

}  // namespace irt::trace
