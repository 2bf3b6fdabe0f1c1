// SPDX-License-Identifier: Apache-2.0
// A point of a surface, found again in another state of the scene.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "irt/scene/scene.h"
#include "irt/trace/ray.h"

namespace irt::trace {

/// Finds points of one state of a scene in another, which has the same slots. One thread only.
class SamePoint {
  public:
    SamePoint(const Scene& now, const Scene& other) : now_(now), other_(other) {}

    /// Where the point of `hit`, now at `position`, is in the other state; both in render space. On
    /// meshes, points and curves it keeps its place on the primitive, on solids its place relative
    /// to their size. Empty where the object is not there, or of another shape or topology.
    [[nodiscard]] std::optional<V3d> find(const Hit& hit, const V3d& position);

  private:
    [[nodiscard]] bool corresponds(const Hit& hit);

    const Scene& now_;
    const Scene& other_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, bool> known_;  ///< by slot and part
};

}  // namespace irt::trace
