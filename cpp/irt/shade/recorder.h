// SPDX-License-Identifier: Apache-2.0
// A source of answers that keeps the questions: the rays of a render, to be timed apart from it.
#pragma once

#include <vector>

#include "irt/trace/intersector.h"

namespace irt::shade {

/// Rays in the order of their queries, nearest hits and shadow rays apart.
struct RayRecord {
    std::vector<trace::Ray> nearest, occlusion;
};

/// Answers as the intersector does and appends every ray to `record`. One thread only.
class Recorder {
  public:
    Recorder(const trace::Intersector& intersector, RayRecord& record)
        : intersector_(intersector), record_(record) {}

    [[nodiscard]] trace::Hit nearest(const trace::Ray& ray, trace::QueryCounts& counts) const {
        record_.nearest.push_back(ray);
        return intersector_.nearest(ray, counts);
    }
    [[nodiscard]] trace::Occlusion occlusion(const trace::Ray& ray, trace::QueryCounts& counts,
                                             const trace::ShadowRule* rule) const {
        record_.occlusion.push_back(ray);
        return intersector_.occlusion(ray, counts, rule);
    }

  private:
    const trace::Intersector& intersector_;
    RayRecord& record_;
};

}  // namespace irt::shade
