// SPDX-License-Identifier: Apache-2.0
// The update of one cell (paper, sections 2 to 4): detect what may have changed, test it, shade
// what did, combine upward along the walked paths. The initial step is the same code over empty
// trees.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "irt/film/cause.h"
#include "irt/history/path_table.h"
#include "irt/history/ray_trees.h"
#include "irt/shade/light_path.h"
#include "irt/shade/shading.h"
#include "irt/shade/whitted.h"
#include "irt/trace/intersector.h"
#include "irt/update/plan.h"
#include "irt/update/reach.h"

namespace irt::update {

/// What an update did (DESIGN 7).
struct UpdateCounts {
    std::uint64_t flagged = 0, tested = 0, retraced = 0, changed = 0;
    std::uint64_t new_rays = 0, nodes_traversed = 0;
    std::uint64_t uncovered = 0;    ///< rays whose visible object is one that changed
    std::uint64_t whole_scene = 0;  ///< of those: rays for which the whole scene was searched
    shade::Counts rays;             ///< rays traced anew, and the work of all

    UpdateCounts& operator+=(const UpdateCounts& other);
};

/// Lists that one cell's update fills, kept so that updates allocate nothing once they are warm.
struct CellLists {
    struct LightNodeIndex {
        history::PointIndex point;
        std::uint32_t light;
    };
    std::vector<history::NodeIndex> flagged;
    std::vector<LightNodeIndex> flagged_shadows;
    std::vector<history::PointIndex> masked;   ///< whose material bit is among the changed ones
    std::vector<history::SampleIndex> walked;  ///< samples whose roots are marked
    std::vector<history::NodeIndex> combined;  ///< nodes to combine, every one after its branches
    std::vector<std::uint32_t> retraced;       ///< by sample: rays retraced; empty: nobody asked
    std::vector<film::CauseCode> causes;       ///< by sample: what changed it; empty: nobody asked

    void clear();
};

class CellUpdate {
  public:
    CellUpdate(const shade::Shading& shading, const trace::Intersector& intersector,
               const Plan& plan, history::PathTable& table, history::RayTrees& trees,
               CellLists& lists);

    /// Traces the cell's next sample and keeps its tree.
    void trace_sample(const trace::Ray& primary);
    /// Keeps of the samples from `first` on, traced since `end`, their intensities alone if nothing
    /// in the shot can change any ray of theirs.
    void settle(history::SampleIndex first, const history::RayTrees::End& end, const Reach& reach);

    // An update: these in turn.

    /// Puts the columns of lights in the order they now have, drops those of lights that are gone
    /// and makes empty ones for new lights.
    void keep_lights();
    /// Looks up the flags of all paths and masks.
    void detect();
    /// Tests every flagged segment and shadow ray against what changed, and marks the nodes that
    /// differ and the ways to their roots.
    void test();
    /// Walks from the marked roots: shades what is marked, traces what is new.
    void shade();
    /// Brings the cumulative intensities along the walked paths up to date.
    void combine();

    /// Samples whose intensity may have changed.
    [[nodiscard]] const std::vector<history::SampleIndex>& walked() const { return lists_.walked; }

    /// The beauty of a sample: scene-linear RGB.
    [[nodiscard]] V3f radiance(history::SampleIndex sample) const;
    /// Whether a sample responds to a light.
    [[nodiscard]] bool responds(history::SampleIndex sample, std::size_t light) const;
    /// A part of the beauty of a sample. Where the part goes by events the sample is not settled.
    [[nodiscard]] V3f part(history::SampleIndex sample, const shade::ResolvedPart& part) const;
    /// What a sample sees first; `surface`: with all fields, not its names alone.
    [[nodiscard]] shade::FirstHit first_hit(history::SampleIndex sample, bool surface) const;

    [[nodiscard]] const UpdateCounts& counts() const { return counts_; }

    // A sample's tree, as shade::ByEvents asks for it.
    using Handle = history::NodeIndex;
    [[nodiscard]] bool meets(Handle node) const {
        return trees_.nodes[node].point != history::no_point;
    }
    [[nodiscard]] bool passes(Handle node) const;
    [[nodiscard]] V3f own(Handle node, std::size_t column) const {
        return intensity(node, column).own;
    }
    [[nodiscard]] V3f cumulative(Handle node, std::size_t column) const {
        return intensity(node, column).cumulative;
    }
    [[nodiscard]] std::optional<Handle> branch(Handle node, int which) const {
        const Handle found = trees_.points[trees_.nodes[node].point].branches[which];
        if (found == history::no_node) return std::nullopt;
        return found;
    }
    [[nodiscard]] V3f weight(Handle node) const { return trees_.nodes[node].weight; }

  private:
    [[nodiscard]] V3f seen_beyond(std::size_t column, history::NodeIndex node) const;
    [[nodiscard]] history::Intensity intensity(Handle node, std::size_t column) const {
        if (column == 0 && !trees_.emits) return {};
        if (!meets(node)) {
            const V3f beyond = seen_beyond(column, node);
            return {beyond, beyond};
        }
        return trees_.columns[column][trees_.nodes[node].point];
    }
    using NodeIndex = history::NodeIndex;
    using PointIndex = history::PointIndex;
    using ShadePoint = shade::VisiblePoint;

    void detect_materials();
    void fetch_point(PointIndex point) const;
    void test_segment(NodeIndex node);
    void test_shadow(PointIndex point, std::size_t light);
    [[nodiscard]] bool record_holds(PointIndex point) const;
    void replace_visible(NodeIndex node, const trace::Hit& hit, const history::HitBehind& behind);
    void light_new_lights();
    void see_other_skies();

    void trace_new(NodeIndex node, const trace::Ray& ray, int depth, std::int64_t cost);
    void walk(NodeIndex node, int depth, std::int64_t cost);
    void shade_point(NodeIndex node, const ShadePoint& point, int depth, std::int64_t cost);
    void respond(const ShadePoint& point, PointIndex at, std::size_t light);
    void trace_shadow(const trace::Ray& ray, PointIndex at, std::size_t light);
    void settle_branch(NodeIndex node, int which, const ShadePoint& point, const V3d& direction,
                       const V3d& weight, int depth, std::int64_t cost);
    [[nodiscard]] bool branch_holds(NodeIndex branch, const trace::Ray& ray,
                                    std::int64_t cost) const;
    void combine_node(NodeIndex node);

    void mark(NodeIndex node, std::uint8_t what);
    /// Notes why the node's sample changes, of several reasons the least.
    void blame(NodeIndex node, film::CauseKind kind, std::uint32_t index);
    [[nodiscard]] std::uint32_t change_of_light(std::size_t light) const;
    void count_retraced(NodeIndex node);
    void count_new(NodeIndex node);
    void count_query(NodeIndex node);
    [[nodiscard]] ShadePoint shade_point_of(NodeIndex node) const {
        return shading_.visible_point(trees_.ray(node), kept_hit(node),
                                      travelled(node, trees_.nodes[node].visible));
    }
    [[nodiscard]] double travelled(NodeIndex node) const;
    /// As much as visible_point needs to know of it.
    [[nodiscard]] double travelled(NodeIndex node, const trace::HitName& visible) const {
        return shading_.varies(material_of(visible)) ? travelled(node) : 0;
    }
    [[nodiscard]] trace::Hit kept_hit(NodeIndex node) const;
    [[nodiscard]] std::uint32_t material_of(const trace::HitName& visible) const;

    const shade::Shading& shading_;
    const trace::Intersector& intersector_;
    const Plan& plan_;
    history::PathTable& table_;
    history::RayTrees& trees_;
    CellLists& lists_;
    const std::vector<LightSlot>& lights_;
    UpdateCounts counts_;
};

}  // namespace irt::update
