// SPDX-License-Identifier: Apache-2.0
// A cage's topology cut by OpenSubdiv. Internal to Subdivider.
#pragma once

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "irt/scene/subdivide.h"

namespace irt {

namespace Far = OpenSubdiv::Far;

/// What OpenSubdiv interpolates: as many as four numbers, in double.
struct Value {
    std::array<double, 4> c{};
    void Clear() { c = {}; }
    void AddWithWeight(const Value& value, double weight) {
        for (std::size_t i = 0; i < c.size(); ++i) c[i] += weight * value.c[i];
    }
    [[nodiscard]] V3d xyz() const { return {c[0], c[1], c[2]}; }
};
using Values = std::vector<Value>;

struct RefinedTopology {
    std::size_t points = 0;                           ///< of the cage
    std::vector<std::int32_t> counts, indices;        ///< of the cage
    std::vector<std::vector<std::int32_t>> channels;  ///< of its face-varying primvars
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::vector<std::int32_t> faces;       ///< refined ones that are no hole
    std::vector<std::int32_t> base_faces;  ///< of `faces`: the face of the cage they are in
    std::vector<bool> creased;             ///< refined vertices that are not smooth all around

    [[nodiscard]] const Far::TopologyLevel& last() const {
        return refiner->GetLevel(refiner->GetMaxLevel());
    }
    /// To mesh.normals; `limits` and two tangents at each vertex.
    void set_normals(const Values& limits, const Values& first, const Values& second,
                     Mesh& mesh) const;

    using Refiner = Far::PrimvarRefinerReal<double>;

    /// `values` of the cage taken to the last level by `step`.
    template <class Step>
    Values refined(Values values, Step&& step) const {
        for (int level = 1; level <= refiner->GetMaxLevel(); ++level) {
            Values next(static_cast<std::size_t>(step.count(refiner->GetLevel(level))));
            step(level, values, next);
            values = std::move(next);
        }
        return values;
    }
};

/// The topology of `cage` cut by `rules`; what of these it is cut without is added to `left_out`.
/// Throws std::invalid_argument as Subdivider::refine does.
std::unique_ptr<RefinedTopology> refined_topology(const Mesh& cage, const Subdivision& rules,
                                                  std::vector<std::string>& left_out);

/// The values that corners of a face-varying primvar show: its indices, or each its own.
std::vector<std::int32_t> channel_of(const Primvar& primvar, std::size_t corners);

/// Whether the surface breaks along an edge that two faces share: its sides have normals of their
/// own. (What sharpness is left at the last level is taken for infinite, as limit positions do.)
bool is_split(const Far::TopologyLevel& level, Far::Index edge);

}  // namespace irt
