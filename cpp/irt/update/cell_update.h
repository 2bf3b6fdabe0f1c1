// SPDX-License-Identifier: Apache-2.0
// The update of one cell (paper, sections 2 to 4): detect what may have changed, re-trace what did,
// combine upward along the walked paths. The initial step is the same code over empty trees.
#pragma once

#include <cstdint>

#include "irt/history/path_table.h"
#include "irt/history/ray_trees.h"
#include "irt/shade/shading.h"
#include "irt/shade/whitted.h"
#include "irt/trace/intersector.h"
#include "irt/update/plan.h"

namespace irt::update {

/// What an update did (DESIGN 7).
struct UpdateCounts {
    std::uint64_t flagged = 0, tested = 0, retraced = 0;
    std::uint64_t changed = 0;  ///< at most so many: a node shaded again counts, equal or not
    std::uint64_t new_rays = 0, nodes_traversed = 0, whole_scene = 0;
    shade::Counts rays;  ///< rays traced anew, and the work of all

    UpdateCounts& operator+=(const UpdateCounts& other);
};

class CellUpdate {
  public:
    CellUpdate(const shade::Shading& shading, const trace::Intersector& intersector,
               const Plan& plan, history::PathTable& table, history::RayTrees& trees)
        : shading_(shading),
          intersector_(intersector),
          plan_(plan),
          table_(table),
          trees_(trees),
          lights_(shading.scene().lights()) {}

    /// Makes the next node the root of a sample's tree; all roots come before any is traced.
    void add_root(const trace::Ray& ray);
    void trace_root(history::NodeIndex root);

    /// Puts the columns of lights in the order they now have, drops those of lights that are gone
    /// and makes empty ones for new lights.
    void keep_lights();
    /// Finds what changed: tests every flagged segment and shadow ray against what changed, and
    /// marks the nodes that differ, and the way there from their roots.
    void detect();
    /// Brings the tree of sample `root` up to date; true if it was marked.
    bool walk_root(history::NodeIndex root);

    /// The beauty of the sample: scene-linear RGB.
    [[nodiscard]] V3f radiance(history::NodeIndex root) const;
    [[nodiscard]] shade::FirstHit first_hit(history::NodeIndex root) const;

    [[nodiscard]] const UpdateCounts& counts() const { return counts_; }

  private:
    using NodeIndex = history::NodeIndex;

    void trace_new(NodeIndex node, std::int64_t cost);
    void walk(NodeIndex node, std::int64_t cost);
    bool find_visible(NodeIndex node);
    void see(NodeIndex node);
    void count_new();
    void count_ray(NodeIndex node);
    void settle(NodeIndex node, std::int64_t cost, bool fresh);
    void settle_lights(NodeIndex node, const shade::VisiblePoint& point, bool fresh);
    [[nodiscard]] std::uint8_t detect_node(NodeIndex node);
    [[nodiscard]] bool shadows_differ(NodeIndex node);
    [[nodiscard]] bool update_shadow(history::ShadowRecord& record, const trace::Ray& ray);
    [[nodiscard]] bool meets_arrivals(const trace::Ray& ray, double t_end) const;
    NodeIndex settle_branch(NodeIndex node, NodeIndex child, const shade::VisiblePoint& point,
                            const V3d& direction, const V3d& weight, std::int64_t cost,
                            std::uint64_t& kind);
    [[nodiscard]] bool record_holds(const history::Node& node) const;
    [[nodiscard]] trace::Ray ray_of(NodeIndex node) const {
        return {trees_.nodes[node].origin, trees_.nodes[node].direction};
    }

    const shade::Shading& shading_;
    const trace::Intersector& intersector_;
    const Plan& plan_;
    history::PathTable& table_;
    history::RayTrees& trees_;
    const std::vector<LightSlot>& lights_;
    UpdateCounts counts_;
};

}  // namespace irt::update
