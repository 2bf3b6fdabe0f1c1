// SPDX-License-Identifier: Apache-2.0
// One cell's history: the extended ray trees of its samples (paper, section 2.2) as flat arrays
// without pointers.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <memory_resource>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "irt/history/path_table.h"
#include "irt/trace/judge_primitive.h"
#include "irt/trace/ray.h"

namespace irt::history {

using NodeIndex = std::uint32_t;
using PointIndex = std::uint32_t;
using SampleIndex = std::uint32_t;
inline constexpr std::uint32_t no_node = 0xffffffffu, no_point = 0xffffffffu;

/// Set in Node::parent of a root; the other bits are then its sample.
inline constexpr std::uint32_t root_bit = 0x80000000u;
/// Set in Node::parent of a branch that is a camera ray still; roots are without it.
inline constexpr std::uint32_t camera_bit = 0x40000000u;
/// Set in RayTrees::roots for a settled sample; the other bits are then its place in `settled`.
inline constexpr std::uint32_t settled_bit = 0x80000000u;

/// A node: a ray, and what it sees, by name and distance. `weight` is the share with which its
/// cumulative intensity joins its parent's; a root's is not read.
struct Node {
    V3f origin, direction;  ///< the ray; render space
    V3f weight;
    NodeIndex parent;
    double t;  ///< of the visible point; infinite where there is none
    trace::HitName visible;
    PointIndex point;  ///< no_point where the ray meets nothing
};
static_assert(sizeof(Node) == 64);

/// Beyond every sum of prices: no branch was traced, or none was cut.
inline constexpr std::int32_t no_price = std::numeric_limits<std::int32_t>::max() / 4;

/// A node's visible point, and what it spawned.
struct KeptPoint {
    NodeIndex node;
    NodeIndex branches[2];  ///< reflected, refracted; or no_node
    /// Prices relative to this node (DESIGN 3, rule 5): the least of its own branches that were
    /// cut; and of all below it, the greatest traced and the least cut.
    std::int32_t own_cut, greatest_traced, least_cut;
    std::int16_t prices[2];  ///< of the branches
    std::uint8_t piece;      ///< as in trace::Hit
};
static_assert(sizeof(KeptPoint) == 32);

/// The intersection history (sections 2.2 and 2.4): the nearest hit on an object outside the
/// dynamic set and other than the visible one. Void once its object has joined that set, or the set
/// was folded.
struct HitBehind {
    trace::HitName hit;
    std::uint32_t epoch = unknown;  ///< of the dynamic set, when it was recorded
    static constexpr std::uint32_t unknown = 0xffffffffu;
};
static_assert(sizeof(HitBehind) == 16);

/// The arrays of a cell, which draw from one block of memory where they are given one.
template <class T>
using Array = std::pmr::vector<T>;

/// The light nodes of one light (section 4.1): what each point's shadow ray met. They keep no voxel
/// history. Empty where the light casts no shadows.
struct LightNodes {
    bool casts_shadows;
    Array<PathIndex> paths;  ///< by point; no_path: it needs no shadow ray of this light
    Array<trace::Occlusion> occlusions;

    explicit LightNodes(bool shadows,
                        std::pmr::memory_resource* memory = std::pmr::get_default_resource())
        : casts_shadows(shadows), paths(memory), occlusions(memory) {}
};

/// What a point itself sends along its ray, and the same with all that joins it from its branches:
/// the cumulative intensity of section 3.2.
struct Intensity {
    V3f own{0, 0, 0}, cumulative{0, 0, 0};
};

/// Intensities by point: the unscaled term, or the responses to one light.
using Column = Array<Intensity>;

/// What the walk has to do at a node. A mark climbs to the root as mark_walk: the cumulative flag
/// of section 3.2, by which everything else is left out.
enum Mark : std::uint8_t {
    mark_walk = 1,   ///< this node's own intensity, or a node below it, changed: combine again
    mark_shade = 2,  ///< its surface shades otherwise: respond and spawn again
    mark_fresh = 4,  ///< its visible point is another: nothing kept below it holds
};

/// Bytes by kind of structure, as in the paper's table 5.
using Sizes = std::vector<std::pair<std::string_view, std::size_t>>;

/// Parts of node i or point i stand at index i of their arrays.
struct RayTrees {
    Array<NodeIndex> roots;  ///< by sample of the cell; or settled_bit and a place in `settled`
    /// By column, as `columns`: cumulative intensities of settled samples, whose trees nothing in
    /// the shot can change, and of which nothing else is kept (contract C5).
    std::vector<Array<V3f>> settled;
    std::uint32_t settled_count = 0;
    std::uint64_t settled_rays = 0;  ///< rays of those trees

    Array<Node> nodes;
    Array<PathIndex> paths;     ///< hash indices; no_path: a free node
    Array<std::uint8_t> marks;  ///< 0 between updates

    Array<KeptPoint> points;
    Array<HitBehind> behind;
    Array<std::uint8_t> material_bits;  ///< the texture mask (section 4.2): a bit's number
    /// The unscaled term, then one by light. The first is empty while it is zero everywhere.
    std::vector<Column> columns;
    bool emits = false;              ///< it is not
    std::vector<LightNodes> lights;  ///< by light

    Array<NodeIndex> free_nodes;
    Array<PointIndex> free_points;
    std::uint64_t shadow_rays = 0;                              ///< light nodes that have a path
    float root_reach = std::numeric_limits<float>::infinity();  ///< t_max of primary rays

    RayTrees() = default;
    /// Empty trees under lights of which `casts_shadows` says which cast shadows.
    RayTrees(const std::vector<bool>& casts_shadows, bool emission,
             std::pmr::memory_resource* memory = std::pmr::get_default_resource());

    /// Fills the column of the unscaled term with zeros, from here on in use.
    void start_emission();

    /// Makes room for as many nodes and points as `like` has, and a share more; `bytes_like` is
    /// what that draws.
    void reserve_like(const RayTrees& like);
    [[nodiscard]] static std::size_t bytes_like(const RayTrees& like);

    /// A node whose fields are unset, but for its point: none.
    NodeIndex add_node();
    /// A point of `node` whose other fields are unset, with no branch and no light node.
    PointIndex add_point(NodeIndex node);
    /// Frees the branch at and below `node`.
    void remove(NodeIndex node);
    /// Frees what `node` sees and everything below it.
    void remove_point(NodeIndex node);
    /// Enters the path of a shadow ray, or no_path.
    void set_shadow_path(std::size_t light, PointIndex point, PathIndex path);

    [[nodiscard]] trace::Ray ray(NodeIndex node) const {
        const Node& n = nodes[node];
        return {n.origin, n.direction,
                n.parent & root_bit ? root_reach : std::numeric_limits<float>::infinity(),
                (n.parent & (root_bit | camera_bit)) != 0};
    }
    /// Of a node that is no root.
    [[nodiscard]] NodeIndex parent(NodeIndex node) const {
        return nodes[node].parent & ~camera_bit;
    }
    [[nodiscard]] bool is_root(NodeIndex node) const {
        return (nodes[node].parent & root_bit) != 0;
    }
    /// Makes `hit` the visible point; gives the node a point, or takes it away, as that needs.
    void set_hit(NodeIndex node, const trace::Hit& hit);

    /// Where the arrays end now, and the rays in them.
    struct End {
        std::size_t nodes, points;
        std::uint64_t rays;
    };
    [[nodiscard]] End end() const { return {nodes.size(), points.size(), rays()}; }
    /// What the ray of a node that meets nothing sees, of a column.
    using SeenBeyond = std::function<V3f(std::size_t column, NodeIndex node)>;
    /// Keeps of the samples from `first` on, which were traced since `end`, their intensities
    /// alone. Only where no node was freed since.
    void settle(SampleIndex first, const End& end, const SeenBeyond& seen_beyond);

    /// Marks `node`, and `mark_walk` from there to its root. True if the root had no mark yet.
    bool mark(NodeIndex node, std::uint8_t what);
    [[nodiscard]] SampleIndex sample_of(NodeIndex node) const;

    [[nodiscard]] std::size_t node_count() const { return nodes.size() - free_nodes.size(); }
    [[nodiscard]] std::size_t point_count() const { return points.size() - free_points.size(); }
    /// Rays the samples are made of: one a node and one a light node.
    [[nodiscard]] std::uint64_t rays() const { return node_count() + shadow_rays + settled_rays; }
    [[nodiscard]] Sizes sizes() const;
};

/// No material, as a bit's number.
inline constexpr std::uint8_t no_material_bit = 64;

/// For checkpoints (checkpoint/arrays.h). Reading fills `trees`, made under no lights; its arrays
/// draw from `memory`.
template <class Archive, class Trees>
void archive(Archive& to, const std::string& name, Trees& trees,
             std::pmr::memory_resource* memory = std::pmr::get_default_resource()) {
    auto& [roots, settled, settled_count, settled_rays, nodes, paths, marks, points, behind,
           material_bits, columns, emits, lights, free_nodes, free_points, shadow_rays,
           root_reach] = trees;
    std::vector<std::uint8_t> shadows;
    if constexpr (Archive::reads) {
        to.array(name + "lights", shadows);
        // Assigning would leave the arrays the memory they had.
        std::destroy_at(&trees);
        std::construct_at(&trees, std::vector<bool>(shadows.begin(), shadows.end()), false, memory);
    } else {
        for (const LightNodes& light : lights) shadows.push_back(light.casts_shadows);
        to.copied(name + "lights", shadows);
    }
    if constexpr (Archive::reads) {
        settled.resize(to.count(name + "settled"));
        columns.clear();
        while (columns.size() < to.count(name + "columns")) columns.emplace_back(memory);
    }
    to.value(name + "settled_count", settled_count);
    to.value(name + "settled_rays", settled_rays);
    to.value(name + "emits", emits);
    to.value(name + "shadow_rays", shadow_rays);
    to.value(name + "root_reach", root_reach);
    to.array(name + "roots", roots);
    to.arrays(
        name + "settled", settled.size(), [&](std::size_t i) -> auto& { return settled[i]; });
    to.array(name + "nodes", nodes);
    to.array(name + "paths", paths);
    to.array(name + "marks", marks);
    to.array(name + "points", points);
    to.array(name + "behind", behind);
    to.array(name + "material_bits", material_bits);
    to.arrays(
        name + "columns", columns.size(), [&](std::size_t i) -> auto& { return columns[i]; });
    to.arrays(
        name + "light_paths", lights.size(), [&](std::size_t i) -> auto& {
            auto& [casts_shadows, light_paths, occlusions] = lights[i];
            return light_paths;
        });
    to.arrays(
        name + "occlusions",
        lights.size(), [&](std::size_t i) -> auto& { return lights[i].occlusions; });
    to.array(name + "free_nodes", free_nodes);
    to.array(name + "free_points", free_points);
}

}  // namespace irt::history
