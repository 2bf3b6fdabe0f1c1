// SPDX-License-Identifier: Apache-2.0
// What the integrator may be told. Defaults are stated in docs/shading.md.
#pragma once

namespace irt::shade {

struct Settings {
    int max_depth = 8;                   ///< bounces after the primary ray
    double throughput_cutoff = 0x1p-10;  ///< a branch below this share of the pixel is not traced
    double mirror_roughness = 0.1;       ///< surfaces of at most this roughness spawn a mirror ray
};

}  // namespace irt::shade
