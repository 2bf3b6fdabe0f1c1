// SPDX-License-Identifier: Apache-2.0
// One cell's history: the extended ray trees of its samples (paper, section 2.2) as flat arrays
// without pointers.
#pragma once

#include <cstdint>
#include <vector>

#include "irt/history/path_table.h"
#include "irt/trace/ray.h"

namespace irt::history {

using NodeIndex = std::uint32_t;
inline constexpr NodeIndex no_node = 0xffffffffu;

/// What the walk has to do at a node.
enum Mark : std::uint8_t {
    mark_walk = 1,   ///< this node or one below it changed: shade and combine again
    mark_fresh = 2,  ///< its visible point is a new one: nothing kept below it holds
};

/// A node: a ray and what it sees. Its cumulative intensity is that of its whole branch (section
/// 3.2): one unscaled term here and a response to each light in RayTrees::columns.
struct Node {
    V3f origin, direction;  ///< the ray; render space
    V3f unscaled;           ///< cumulative
    trace::Hit hit;         ///< the visible point, or none
    /// The intersection history: the nearest hit on an object outside the dynamic set and other
    /// than the visible one. Void once its object has joined that set, or the set was folded.
    trace::Hit behind;
    NodeIndex parent, reflected, refracted;
    std::uint32_t epoch;  ///< of the dynamic set, when `behind` was recorded
    /// Of the branches below, in prices relative to this node: the greatest traced and the least
    /// cut (DESIGN 3, rule 5).
    std::int32_t greatest_traced, least_cut;
    std::uint8_t depth;
    bool behind_known;
};

/// A light node (section 4.1): what a shadow ray met. It keeps no voxel history.
struct ShadowRecord {
    PathIndex path = no_path;  ///< no_path: the point needs no shadow ray of this light
    trace::Occlusion occlusion;
};

/// Node i's parts stand at index i of every array. The first nodes are the samples' roots, in
/// order.
struct RayTrees {
    std::vector<Node> nodes;
    std::vector<PathIndex> paths;             ///< no_path: a free node
    std::vector<std::uint32_t> objects;       ///< slot of the visible object, or none
    std::vector<std::uint8_t> material_bits;  ///< the texture mask (section 4.2): a bit's number
    std::vector<std::uint8_t> marks;          ///< 0 between updates
    std::vector<std::vector<V3f>> columns;    ///< by light, then node: cumulative responses
    std::vector<std::vector<ShadowRecord>> shadows;  ///< by light, then node
    std::vector<NodeIndex> free;
    std::uint64_t shadow_rays = 0;  ///< records that have a path

    explicit RayTrees(std::size_t lights = 0) : columns(lights), shadows(lights) {}

    /// A node whose fields but for the arrays' are unset.
    NodeIndex add();
    /// Frees the branch below and at `node`.
    void remove(NodeIndex node);
    /// Enters the path of a shadow ray, or no_path.
    void set_shadow_path(ShadowRecord& record, PathIndex path);
    /// Marks `node`, and `mark_walk` from there to its root.
    void mark(NodeIndex node, std::uint8_t what);
    /// Rays the trees hold: one a node and one a shadow record.
    [[nodiscard]] std::uint64_t rays() const { return nodes.size() - free.size() + shadow_rays; }
    [[nodiscard]] std::size_t bytes() const;
};

/// No material, as a bit's number.
inline constexpr std::uint8_t no_material_bit = 64;

}  // namespace irt::history
