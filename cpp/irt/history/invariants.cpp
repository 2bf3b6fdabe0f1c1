// SPDX-License-Identifier: Apache-2.0
#include "irt/history/invariants.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <vector>

#include "irt/math/bits.h"
#include "irt/shade/fresh_stack.h"
#include "irt/trace/candidate.h"
#include "irt/trace/judge_object.h"

namespace irt::history {

namespace {

bool same_hit(const trace::Hit& a, const trace::Hit& b) {
    return a.object == b.object && a.part == b.part && a.primitive == b.primitive &&
           a.piece == b.piece && same_bits(a.t, b.t) && same_bits(a.u, b.u) && same_bits(a.v, b.v);
}

bool same_name(const trace::HitName& a, const trace::HitName& b) {
    return a.object == b.object && a.part == b.part && a.primitive == b.primitive;
}

/// Whether an opaque part of object `slot` is on a shadow ray of `light`.
bool blocks(const Scene& scene, std::uint32_t slot, const trace::Ray& ray, const LightSlot& light) {
    return trace::judge_object(scene, slot, trace::judge_ray(ray), ray.camera,
                               [&](const trace::Hit& hit) {
                                   trace::Occlusion sum;
                                   trace::add_occluder(scene, ray, hit, sum, light.rule());
                                   return sum.blocker != trace::none;
                               });
}

class Checker {
  public:
    Checker(const RayTrees& trees, const PathTable& table, const shade::Shading& shading,
            const trace::Intersector& intersector, const std::string& where)
        : trees_(trees),
          table_(table),
          shading_(shading),
          intersector_(intersector),
          where_(where),
          scene_(shading.scene()),
          lights_(scene_.lights()) {}

    void run() {
        sizes();
        node_used_.assign(trees_.nodes.size(), false);
        point_used_.assign(trees_.points.size(), false);
        settled_used_.assign(trees_.settled_count, false);
        for (SampleIndex sample = 0; sample < trees_.roots.size(); ++sample)
            if (trees_.roots[sample] & settled_bit)
                settled(trees_.roots[sample] & ~settled_bit);
            else
                branch(trees_.roots[sample], root_bit | sample, 0, 0, 0);
        require(std::count(settled_used_.begin(), settled_used_.end(), false) == 0,
                "every settled intensity belongs to a sample");
        free_list("node", trees_.free_nodes, node_used_);
        free_list("point", trees_.free_points, point_used_);
        free_entries();
        require(shadow_rays_ == trees_.shadow_rays, "shadow_rays counts what has a path");
        require(nodes_ == trees_.node_count(), "node_count counts what is reached");
        require(points_ == trees_.point_count(), "point_count counts what is reached");
    }

  private:
    void require(bool holds, const char* invariant) const {
        if (!holds) throw std::logic_error(where_ + ": broken: " + invariant);
    }
    void require(bool holds, const char* what, std::uint32_t index, const char* invariant) const {
        if (!holds)
            throw std::logic_error(where_ + ", " + what + " " + std::to_string(index) +
                                   ": broken: " + invariant);
    }
    void require(bool holds, NodeIndex node, const char* invariant) const {
        require(holds, "node", node, invariant);
    }

    void sizes() const {
        const std::size_t nodes = trees_.nodes.size(), points = trees_.points.size();
        require(trees_.paths.size() == nodes && trees_.marks.size() == nodes,
                "arrays by node are of one size");
        require(trees_.behind.size() == points && trees_.material_bits.size() == points,
                "arrays by point are of one size");
        require(trees_.columns.size() == lights_.size() + 1, "a column a light, and one");
        require(trees_.settled_count == 0 || trees_.settled.size() == trees_.columns.size(),
                "a column of settled intensities a light, and one");
        require(trees_.lights.size() == lights_.size(), "light nodes for every light");
        require(trees_.emits || !shading_.emits(), "an emitting scene has an unscaled column");
        for (std::size_t c = 0; c < trees_.columns.size(); ++c) {
            const bool used = c > 0 || trees_.emits;
            const std::size_t size = used ? points : 0;
            require(trees_.columns[c].size() == size, "columns have an entry a point");
            require(trees_.settled_count == 0 ||
                        trees_.settled[c].size() == (used ? trees_.settled_count : 0),
                    "columns have an entry a settled sample");
        }
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            const LightNodes& light = trees_.lights[l];
            require(light.casts_shadows == lights_[l].record.casts_shadows,
                    "light nodes cast shadows as their light does");
            const std::size_t size = light.casts_shadows ? points : 0;
            require(light.paths.size() == size && light.occlusions.size() == size,
                    "a light that casts shadows has a light node a point, others have none");
        }
    }

    void settled(std::uint32_t place) {
        require(place < settled_used_.size() && !settled_used_[place], "settled sample", place,
                "a settled intensity belongs to one sample");
        settled_used_[place] = true;
    }

    /// A node reached from `parent`, and all below it.
    void branch(NodeIndex index, NodeIndex parent, int depth, std::int64_t cost, double travelled) {
        require(index < trees_.nodes.size(), index, "links lead to nodes");
        require(!node_used_[index], index, "a node is reached once");
        node_used_[index] = true;
        ++nodes_;
        const Node& node = trees_.nodes[index];
        require((node.parent & ~camera_bit) == parent, index,
                "the parent is what the node was reached from");
        require(trees_.marks[index] == 0, index, "no marks between updates");
        path(index, trees_.paths[index], table_.grid().path(node.origin, node.direction, node.t));
        const trace::Hit seen = visible(index);
        if (node.point == no_point) return;
        require(node.point < trees_.points.size(), index, "links lead to points");
        require(!point_used_[node.point], index, "a point belongs to one node");
        point_used_[node.point] = true;
        ++points_;
        const KeptPoint& kept = trees_.points[node.point];
        require(kept.node == index, index, "the point's node is the one that has it");
        require(seen.piece == kept.piece, index, "the kept piece is that of the visible hit");
        behind(index);
        const shade::VisiblePoint point =
            shading_.visible_point(trees_.ray(index), seen, travelled);
        require(trees_.material_bits[node.point] == point.surface.material % 64, index,
                "the material mask is that of the visible material");
        if (trees_.emits)
            require(same_bits(trees_.columns[0][node.point].own, V3f(point.response().emission)),
                    index, "the unscaled term is the emission");
        for (std::size_t l = 0; l < lights_.size(); ++l) response(index, point, l);
        travelled += shade::Shading::length(trees_.ray(index), seen.t);
        branches(index, point, depth, cost, travelled);
        cumulative(index);
    }

    void path(NodeIndex node, PathIndex index, Path expected) const {
        require(index != no_path && index < table_.capacity(), node, "a ray has a path");
        require(index == any_path || table_.path(index) == expected, node,
                "the hash index is that of the ray's path");
    }

    trace::Hit visible(NodeIndex index) const {
        const Node& node = trees_.nodes[index];
        const trace::Ray ray = trees_.ray(index);
        const bool seen = node.point != no_point;
        require(seen == (node.visible.object != trace::none), index,
                "a point where something is visible, and nowhere else");
        if (seen)
            require(node.visible.object < scene_.slot_count() && scene_.live(node.visible.object),
                    index, "the visible object is in the scene");
        const trace::Hit named = trace::named_hit(scene_, ray, node.visible);
        require(same_bits(named.t, node.t), index, "the visible hit, judged again, has its t");
        trace::QueryCounts counts;
        require(same_hit(named, intersector_.nearest(ray, counts)), index,
                "the visible hit is the nearest");
        return named;
    }

    void behind(NodeIndex index) const {
        const Node& node = trees_.nodes[index];
        const HitBehind& record = trees_.behind[node.point];
        if (record.epoch != intersector_.epoch()) return;
        if (record.hit.object != trace::none && intersector_.moves(record.hit.object)) return;
        trace::Hit second;
        trace::QueryCounts counts;
        (void)intersector_.nearest_and_behind(trees_.ray(index), second, counts);
        require(same_name(record.hit, trace::HitName(second)), index,
                "a record that holds is the nearest hit outside the dynamic set on another object");
    }

    void response(NodeIndex index, const shade::VisiblePoint& point, std::size_t l) {
        const PointIndex at = trees_.nodes[index].point;
        const LightNodes& light = trees_.lights[l];
        const std::optional<shade::LightSample> sample = shading_.light_sample(point, lights_[l]);
        const bool has_path = light.casts_shadows && light.paths[at] != no_path;
        require(has_path == (sample && sample->shadow_ray), index,
                "a light node has a path where the point needs a shadow ray");
        shadow_rays_ += has_path;
        V3d own = sample ? sample->response : V3d(0, 0, 0);
        if (has_path) {
            const trace::Ray& ray = *sample->shadow_ray;
            const trace::Occlusion& kept = light.occlusions[at];
            path(index, light.paths[at],
                 table_.grid().path(ray.origin, ray.direction, static_cast<double>(ray.t_max)));
            trace::QueryCounts counts;
            require(kept.depth == intersector_.occlusion(ray, counts, lights_[l].rule()).depth,
                    index, "a shadow record has the optical depth of its ray");
            require(kept.blocker == trace::none ||
                        (kept.blocker < scene_.slot_count() && scene_.live(kept.blocker) &&
                         blocks(scene_, kept.blocker, ray, lights_[l])),
                    index, "the blocker of a shadow record is opaque and on its ray");
            own *= shade::shadowed(lights_[l].record, kept);
        }
        require(same_bits(trees_.columns[1 + l][at].own, V3f(own)), index,
                "the own intensity is the response to the light");
    }

    void branches(NodeIndex index, const shade::VisiblePoint& point, int depth, std::int64_t cost,
                  double travelled) {
        const KeptPoint& kept = trees_.points[trees_.nodes[index].point];
        shade::Spawned rays;
        if (depth < shading_.max_depth()) rays = shading_.spawned(point);
        std::int32_t cut = no_price;
        for (int which = 0; which < 2; ++which) {
            const V3f weight(which == 0 ? rays.reflect_weight : rays.refract_weight);
            const V3d& direction = which == 0 ? rays.reflect_direction : rays.refract_direction;
            const std::optional<std::int64_t> price = shade::price(weight);
            const bool traced = price && shading_.affordable(cost + *price);
            if (price && !traced) cut = std::min(cut, static_cast<std::int32_t>(*price));
            const NodeIndex below = kept.branches[which];
            require(traced == (below != no_node), index,
                    "branches are those that the point spawns and the cut-off leaves");
            if (!traced) continue;
            require(below < trees_.nodes.size(), index, "links lead to nodes");
            const Node& spawned = trees_.nodes[below];
            const trace::Ray ray = shading_.spawned_ray(point, direction);
            require(kept.prices[which] == *price && same_bits(spawned.weight, weight), index,
                    "a branch has the weight and price that the point gives it");
            require(same_bits(spawned.origin, ray.origin) &&
                        same_bits(spawned.direction, ray.direction) &&
                        trees_.ray(below).camera == ray.camera,
                    below, "a branch's ray is the one that its point spawns");
            shade::with_stack_for(
                depth + 1, [&] { branch(below, index, depth + 1, cost + *price, travelled); });
        }
        require(kept.own_cut == cut, index, "own_cut is the least price of the branches cut");
    }

    /// What update::CellUpdate::combine keeps of a node, made again from its point and branches.
    void cumulative(NodeIndex index) const {
        const PointIndex at = trees_.nodes[index].point;
        const KeptPoint& kept = trees_.points[at];
        std::int32_t traced = -no_price, cut = kept.own_cut;
        for (int which = 0; which < 2; ++which) {
            if (kept.branches[which] == no_node) continue;
            traced = std::max<std::int32_t>(traced, kept.prices[which]);
            const PointIndex below = trees_.nodes[kept.branches[which]].point;
            if (below == no_point) continue;
            const KeptPoint& point = trees_.points[below];
            if (point.greatest_traced != -no_price)
                traced = std::max(traced, kept.prices[which] + point.greatest_traced);
            if (point.least_cut != no_price)
                cut = std::min(cut, kept.prices[which] + point.least_cut);
        }
        require(kept.greatest_traced == traced, index,
                "greatest_traced is the greatest price of all traced below");
        require(kept.least_cut == cut, index, "least_cut is the least price of all cut below");
        for (std::size_t c = trees_.emits ? 0 : 1; c < trees_.columns.size(); ++c) {
            const Column& column = trees_.columns[c];
            V3f sum = column[at].own;
            for (const NodeIndex branch : kept.branches) {
                if (branch == no_node) continue;
                const Node& node = trees_.nodes[branch];
                sum = shade::add_scaled(
                    sum, node.weight,
                    node.point == no_point
                        ? (c == 0 ? V3f(0, 0, 0)
                                  : shading_.seen_beyond(lights_[c - 1], trees_.ray(branch)))
                        : column[node.point].cumulative);
            }
            require(same_bits(column[at].cumulative, sum), index,
                    "cumulative intensities are the sums of own ones and branches");
        }
    }

    /// Names every entry that is not in use, and once.
    void free_list(const char* what, const Array<std::uint32_t>& list,
                   std::vector<bool>& used) const {
        for (const std::uint32_t index : list) {
            require(index < used.size(), what, index, "free lists name entries");
            require(!used[index], what, index, "what is free is neither in use nor freed twice");
            used[index] = true;
        }
        const auto lost = std::find(used.begin(), used.end(), false);
        require(lost == used.end(), what, static_cast<std::uint32_t>(lost - used.begin()),
                "what is not in use is free");
    }

    void free_entries() const {
        for (const NodeIndex node : trees_.free_nodes)
            require(trees_.paths[node] == no_path && trees_.marks[node] == 0 &&
                        trees_.nodes[node].point == no_point,
                    node, "a free node has no path, mark or point");
        for (const PointIndex point : trees_.free_points) {
            require(trees_.points[point].node == no_node &&
                        trees_.material_bits[point] == no_material_bit,
                    "point", point, "a free point has no node and no material");
            for (const LightNodes& light : trees_.lights)
                require(!light.casts_shadows || light.paths[point] == no_path, "point", point,
                        "a free point has no shadow ray");
        }
    }

    const RayTrees& trees_;
    const PathTable& table_;
    const shade::Shading& shading_;
    const trace::Intersector& intersector_;
    const std::string& where_;
    const Scene& scene_;
    const std::vector<LightSlot>& lights_;
    std::vector<bool> node_used_, point_used_, settled_used_;
    std::size_t nodes_ = 0, points_ = 0;
    std::uint64_t shadow_rays_ = 0;
};

}  // namespace

void check_invariants(const RayTrees& trees, const PathTable& table, const shade::Shading& shading,
                      const trace::Intersector& intersector, const std::string& where) {
    Checker(trees, table, shading, intersector, where).run();
}

}  // namespace irt::history
