// SPDX-License-Identifier: Apache-2.0
// The loop that the intersector's speed is measured against (DESIGN 7): Embree's own triangles and
// instances, ROBUST, no filter; quadrics by the same judge; single rays; nothing kept of the hits.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "irt/trace/intersector.h"

namespace irt::trace {

/// One pass over the rays, on the calling thread.
struct LoopTime {
    double seconds = 0;
    std::size_t hits = 0;  ///< rays that met something
};

class BareLoop {
  public:
    /// Throws std::invalid_argument as Intersector does.
    explicit BareLoop(const Scene& scene, const std::string& isa = "avx2");
    ~BareLoop();
    BareLoop(const BareLoop&) = delete;
    BareLoop& operator=(const BareLoop&) = delete;

    [[nodiscard]] LoopTime nearest(std::span<const Ray> rays) const;
    [[nodiscard]] LoopTime occlusion(std::span<const Ray> rays) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// The same passes through `intersector`.
[[nodiscard]] LoopTime time_nearest(const Intersector& intersector, std::span<const Ray> rays);
[[nodiscard]] LoopTime time_occlusion(const Intersector& intersector, std::span<const Ray> rays);

}  // namespace irt::trace
