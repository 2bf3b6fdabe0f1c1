// SPDX-License-Identifier: Apache-2.0
// The brute-force twin as a source of answers in the Intersector's place.
#pragma once

#include "irt/trace/intersector.h"

namespace irt::trace {

class BruteForce {
  public:
    explicit BruteForce(const Scene& scene) : scene_(scene) {}

    [[nodiscard]] Hit nearest(const Ray& ray, QueryCounts& counts) const {
        ++counts.nearest;
        return brute_force_nearest(scene_, ray);
    }
    [[nodiscard]] Occlusion occlusion(const Ray& ray, QueryCounts& counts,
                                      const ShadowRule* rule) const {
        ++counts.occlusion;
        return brute_force_occlusion(scene_, ray, rule);
    }

  private:
    const Scene& scene_;
};

}  // namespace irt::trace
