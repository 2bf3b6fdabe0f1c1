// SPDX-License-Identifier: Apache-2.0
// Whitted ray tracing of one sample (Whitted 1980), as a tree whose results combine bottom-up: a
// node's cumulative intensity is that of its visible point plus those of its two branches (paper,
// section 3.2), kept as one unscaled term and a unit-energy response for each light (DESIGN 3,
// rule 3).
#pragma once

#include <cstdint>
#include <vector>

#include "irt/shade/light_path.h"
#include "irt/shade/shading.h"

namespace irt::shade {

/// Rays and work of one thread.
struct Counts {
    std::uint64_t primary = 0, reflected = 0, refracted = 0, shadow = 0, shadings = 0;
    trace::QueryCounts queries;

    [[nodiscard]] std::uint64_t rays() const { return primary + reflected + refracted + shadow; }
    Counts& operator+=(const Counts& other);
};

/// What a thread needs to trace samples, so that tracing allocates nothing.
struct Scratch {
    std::vector<V3f> columns;    ///< one response a light, level by level of the tree
    bool surface_wanted = true;  ///< false: of `first`, the names alone are needed
    FirstHit first;
    bool tree_wanted = false;  ///< for parts of the beauty
    SampleTree tree;
    Counts counts;
};

/// Traces samples, keeping nothing of their trees. `Source` answers the queries: trace::Intersector
/// or trace::BruteForce. Shared by all threads.
template <class Source>
class Whitted {
  public:
    Whitted(const Scene& scene, const Source& source, const Settings& settings, const RayCone& cone)
        : shading_(scene, settings, cone), source_(source) {}

    [[nodiscard]] const Scene& scene() const { return shading_.scene(); }
    [[nodiscard]] Scratch make_scratch() const;
    /// The beauty of the sample whose primary ray is `ray`: scene-linear RGB.
    [[nodiscard]] V3f sample(const trace::Ray& ray, Scratch& scratch) const;

  private:
    V3f trace(const trace::Ray& ray, int depth, std::int64_t cost, double travelled,
              Scratch& scratch) const;
    void shade_lights(const VisiblePoint& point, V3f* columns, Scratch& scratch) const;
    void branch(const VisiblePoint& point, const V3d& direction, const V3d& weight, int depth,
                std::int64_t cost, double travelled, V3f& unscaled, std::uint64_t& kind,
                SampleTree::Handle node, int which, Scratch& scratch) const;
    void keep(SampleTree::Handle node, SampleTree::Value value, const V3f& unscaled,
              const V3f* columns, Scratch& scratch) const;
    [[nodiscard]] V3f* level(Scratch& scratch, int depth) const {
        return scratch.columns.data() + static_cast<std::size_t>(depth) * lights().size();
    }
    [[nodiscard]] const std::vector<LightSlot>& lights() const { return shading_.scene().lights(); }

    Shading shading_;
    const Source& source_;
};

}  // namespace irt::shade
