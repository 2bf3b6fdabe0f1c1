// SPDX-License-Identifier: Apache-2.0
#include "irt/update/cell_update.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "irt/math/bits.h"

namespace irt::update {

using history::mark_fresh;
using history::mark_walk;
using history::no_node;
using history::no_path;
using history::Node;
using history::ShadowRecord;

namespace {

/// No branch was traced, or none was cut: beyond every sum of prices.
constexpr std::int32_t no_price = std::numeric_limits<std::int32_t>::max() / 4;

bool same(const trace::Hit& a, const trace::Hit& b) {
    return a.object == b.object && a.part == b.part && a.primitive == b.primitive &&
           a.piece == b.piece && same_bits(a.t, b.t) && same_bits(a.u, b.u) && same_bits(a.v, b.v);
}

}  // namespace

UpdateCounts& UpdateCounts::operator+=(const UpdateCounts& other) {
    flagged += other.flagged;
    tested += other.tested;
    retraced += other.retraced;
    changed += other.changed;
    new_rays += other.new_rays;
    nodes_traversed += other.nodes_traversed;
    whole_scene += other.whole_scene;
    rays += other.rays;
    return *this;
}

void CellUpdate::add_root(const trace::Ray& ray) {
    const NodeIndex root = trees_.add();
    Node& node = trees_.nodes[root];
    node.origin = ray.origin;
    node.direction = ray.direction;
    node.parent = no_node;
    node.depth = 0;
}

void CellUpdate::trace_root(NodeIndex root) {
    ++counts_.rays.primary;
    trace_new(root, 0);
}

// ---- detection
// -----------------------------------------------------------------------------------

void CellUpdate::keep_lights() {
    std::vector<std::vector<V3f>> columns(lights_.size());
    std::vector<std::vector<ShadowRecord>> shadows(lights_.size());
    for (std::size_t l = 0; l < lights_.size(); ++l) {
        if (plan_.kept_lights[l]) {
            columns[l] = std::move(trees_.columns[*plan_.kept_lights[l]]);
            shadows[l] = std::move(trees_.shadows[*plan_.kept_lights[l]]);
        } else {
            columns[l].resize(trees_.nodes.size(), V3f(0, 0, 0));
            shadows[l].resize(trees_.nodes.size());
        }
    }
    trees_.columns = std::move(columns);
    for (auto& gone : trees_.shadows)
        for (ShadowRecord& record : gone) trees_.set_shadow_path(record, no_path);
    trees_.shadows = std::move(shadows);
}

void CellUpdate::detect() {
    if (!plan_.lights_moved && !plan_.flags_objects()) return;
    for (NodeIndex node = 0; node < trees_.nodes.size(); ++node)
        if (trees_.paths[node] != no_path)
            if (const std::uint8_t what = detect_node(node)) trees_.mark(node, what);
}

/// Marks due to what this node itself reads: its segment, its material, its lights.
std::uint8_t CellUpdate::detect_node(NodeIndex node) {
    const std::uint32_t object = trees_.objects[node];
    const bool hit = object != trace::none;
    const std::uint8_t bit = trees_.material_bits[node];
    const bool reshaded = hit && ((plan_.material_mask >> bit & 1) || plan_.lights_moved ||
                                  (!plan_.rebound.empty() && plan_.rebound[object]));
    const bool crossed =
        table_.flagged(trees_.paths[node]) || (hit && plan_.geometry_changed[object]);
    bool fresh = false;
    if (crossed) fresh = find_visible(node);
    counts_.flagged += crossed || reshaded;
    if (fresh) {
        ++counts_.changed;
        return mark_fresh | mark_walk;
    }
    const bool relit = shadows_differ(node);
    counts_.changed += reshaded;
    return reshaded || relit ? mark_walk : 0;
}

/// Redoes the flagged shadow rays of a node whose visible point stands; true if one differs.
bool CellUpdate::shadows_differ(NodeIndex node) {
    bool differ = false;
    std::optional<shade::VisiblePoint> point;
    for (std::size_t l = 0; l < lights_.size(); ++l) {
        ShadowRecord& record = trees_.shadows[l][node];
        if (!table_.flagged(record.path)) continue;
        ++counts_.flagged;
        // An opaque blocker that stays keeps the point dark, whatever else moves (DESIGN 4, step
        // 4).
        const std::uint32_t blocker = record.occlusion.blocker;
        if (blocker != trace::none && !plan_.tint_changed[blocker]) continue;
        if (!point) point.emplace(shading_.visible_point(ray_of(node), trees_.nodes[node].hit));
        const trace::Ray ray = shading_.shadow_ray(*point, lights_[l]);
        if (update_shadow(record, ray)) {
            ++counts_.changed;
            differ = true;
        }
    }
    return differ;
}

/// Whether a segment may meet what changed, where that now is.
bool CellUpdate::meets_arrivals(const trace::Ray& ray, double t_end) const {
    return std::any_of(plan_.arrivals.begin(), plan_.arrivals.end(), [&](const trace::Box& box) {
        double enter = 0, exit = t_end;
        return trace::clip(box, V3d(ray.origin), V3d(ray.direction), enter, exit);
    });
}

// ---- the walk
// ------------------------------------------------------------------------------------

bool CellUpdate::walk_root(NodeIndex root) {
    if (!trees_.marks[root]) return false;
    walk(root, 0);
    return true;
}

void CellUpdate::walk(NodeIndex node, std::int64_t cost) {
    ++counts_.nodes_traversed;
    if (trees_.marks[node] & mark_fresh) {
        trees_.remove(std::exchange(trees_.nodes[node].reflected, no_node));
        trees_.remove(std::exchange(trees_.nodes[node].refracted, no_node));
        see(node);
        settle(node, cost, true);
    } else {
        settle(node, cost, false);
    }
    trees_.marks[node] = 0;
}

bool CellUpdate::record_holds(const Node& node) const {
    return node.behind_known && node.epoch == intersector_.epoch() &&
           (!node.behind || !intersector_.moves(node.behind.object));
}

/// Recomputes the visible point from the history (section 2.4); true if it may differ from before
/// in any way.
bool CellUpdate::find_visible(NodeIndex index) {
    Node& node = trees_.nodes[index];
    const trace::Ray ray = ray_of(index);
    const trace::Hit was = node.hit;
    trace::QueryCounts& queries = counts_.rays.queries;
    ++counts_.tested;
    if (!was || !plan_.geometry_changed[was.object]) {
        // Nothing that stayed hides it; what changed may.
        if (!meets_arrivals(ray, was.t)) return false;
        count_ray(index);
        node.hit = intersector_.nearest_moving(ray, was, queries);
        if (same(node.hit, was)) return false;
        if (!was || !intersector_.moves(was.object)) {
            node.behind = was;
            node.behind_known = true;
        } else {
            node.behind_known = record_holds(node);
        }
        node.epoch = intersector_.epoch();
        return true;
    }
    ++counts_.retraced;
    count_ray(index);
    if (record_holds(node)) {
        node.hit = intersector_.nearest_moving(ray, node.behind, queries);
        node.behind_known = node.hit.object != node.behind.object || !node.behind;
        return true;
    }
    ++counts_.whole_scene;
    node.hit = intersector_.nearest_and_behind(ray, node.behind, queries);
    node.behind_known = true;
    node.epoch = intersector_.epoch();
    return true;
}

/// A ray that was not there: flagged, retraced and changed by that.
void CellUpdate::count_new() {
    ++counts_.new_rays;
    ++counts_.flagged;
    ++counts_.retraced;
    ++counts_.changed;
}

/// A query for a node's ray that was there.
void CellUpdate::count_ray(NodeIndex node) {
    const NodeIndex parent = trees_.nodes[node].parent;
    if (parent == no_node)
        ++counts_.rays.primary;
    else if (trees_.nodes[parent].reflected == node)
        ++counts_.rays.reflected;
    else
        ++counts_.rays.refracted;
}

/// Enters what `node` sees into the arrays that detection scans.
void CellUpdate::see(NodeIndex node) {
    const trace::Hit& hit = trees_.nodes[node].hit;
    trees_.paths[node] = table_.intern(
        table_.grid().path(trees_.nodes[node].origin, trees_.nodes[node].direction, hit.t));
    trees_.objects[node] = hit.object;
    trees_.material_bits[node] = history::no_material_bit;
}

/// Traces a node that has its ray, and everything below it (section 2.5).
void CellUpdate::trace_new(NodeIndex index, std::int64_t cost) {
    count_new();
    Node& node = trees_.nodes[index];
    node.reflected = node.refracted = no_node;
    node.hit = intersector_.nearest_and_behind(ray_of(index), node.behind, counts_.rays.queries);
    node.behind_known = true;
    node.epoch = intersector_.epoch();
    see(index);
    settle(index, cost, true);
}

// ---- one node
// ------------------------------------------------------------------------------------

/// Brings the cumulative values of `node` up to date. Its visible point is known; `fresh`: and is a
/// new one, so that nothing kept of its shadow rays and branches holds.
void CellUpdate::settle(NodeIndex index, std::int64_t cost, bool fresh) {
    trees_.nodes[index].unscaled = {0, 0, 0};
    trees_.nodes[index].greatest_traced = -no_price;
    trees_.nodes[index].least_cut = no_price;
    if (!trees_.nodes[index].hit) {
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            trees_.columns[l][index] = {0, 0, 0};
            trees_.set_shadow_path(trees_.shadows[l][index], no_path);
        }
        return;
    }
    const shade::VisiblePoint point =
        shading_.visible_point(ray_of(index), trees_.nodes[index].hit);
    trees_.material_bits[index] = point.surface.material % 64;
    settle_lights(index, point, fresh);
    trees_.nodes[index].unscaled = V3f(point.response.emission);
    if (trees_.nodes[index].depth == shading_.max_depth()) return;
    const shade::Spawned rays = shading_.spawned(point);
    const NodeIndex reflected =
        settle_branch(index, trees_.nodes[index].reflected, point, rays.reflect_direction,
                      rays.reflect_weight, cost, counts_.rays.reflected);
    trees_.nodes[index].reflected = reflected;
    const NodeIndex refracted =
        settle_branch(index, trees_.nodes[index].refracted, point, rays.refract_direction,
                      rays.refract_weight, cost, counts_.rays.refracted);
    trees_.nodes[index].refracted = refracted;
}

void CellUpdate::settle_lights(NodeIndex node, const shade::VisiblePoint& point, bool fresh) {
    ++counts_.rays.shadings;
    for (std::size_t l = 0; l < lights_.size(); ++l) {
        ShadowRecord& record = trees_.shadows[l][node];
        V3f& column = trees_.columns[l][node];
        const std::optional<shade::LightSample> sample = shading_.light_sample(point, lights_[l]);
        if (!sample || !sample->shadow_ray) trees_.set_shadow_path(record, no_path);
        if (!sample) {
            column = {0, 0, 0};
            continue;
        }
        V3d response = sample->response;
        if (sample->shadow_ray) {
            const trace::Ray& ray = *sample->shadow_ray;
            if (fresh || record.path == no_path) {
                ++counts_.rays.shadow;
                count_new();
                record.occlusion = intersector_.occlusion(ray, counts_.rays.queries);
                trees_.set_shadow_path(
                    record, table_.intern(table_.grid().path(ray.origin, ray.direction,
                                                             static_cast<double>(ray.t_max))));
            }
            response *= shade::transmittance(record.occlusion);
        }
        column = V3f(response);
    }
}

/// Redoes a flagged shadow ray (section 4.1) as far as what changed can matter to it; true if it
/// lets another share of light through.
bool CellUpdate::update_shadow(ShadowRecord& record, const trace::Ray& ray) {
    const trace::Occlusion was = record.occlusion;
    ++counts_.tested;
    if (was.blocker == trace::none && was.depth == trace::OpticalDepth{}) {
        // Nothing was in between, so nothing that stays is, unless it began to stop light.
        if (!meets_arrivals(ray, static_cast<double>(ray.t_max))) return false;
        if (!plan_.still_tint_changed) {
            ++counts_.rays.shadow;
            record.occlusion = intersector_.occlusion_moving(ray, counts_.rays.queries);
            return !(record.occlusion.depth == was.depth);
        }
    }
    ++counts_.rays.shadow;
    ++counts_.retraced;
    record.occlusion = intersector_.occlusion(ray, counts_.rays.queries);
    return !(record.occlusion.depth == was.depth);
}

/// One branch of `node`: kept, walked, traced anew or cut, as its weight and direction now say;
/// then its cumulative intensity joins the node's. Returns the branch's node.
history::NodeIndex CellUpdate::settle_branch(NodeIndex node, NodeIndex child,
                                             const shade::VisiblePoint& point, const V3d& direction,
                                             const V3d& weight, std::int64_t cost,
                                             std::uint64_t& kind) {
    const V3f share(weight);
    const std::optional<std::int64_t> own = shade::price(share);
    const bool traced = own && shading_.affordable(cost + *own);
    if (own && !traced)
        trees_.nodes[node].least_cut =
            std::min(trees_.nodes[node].least_cut, static_cast<std::int32_t>(*own));
    if (!traced) {
        trees_.remove(child);
        return no_node;
    }
    const std::int64_t below = cost + *own;
    const trace::Ray ray = shading_.spawned_ray(point, direction);
    if (child != no_node) {
        const Node& kept = trees_.nodes[child];
        // Another price upstream may cut what was traced below, or trace what was cut.
        const bool holds =
            same_bits(kept.origin, ray.origin) && same_bits(kept.direction, ray.direction) &&
            (kept.greatest_traced == -no_price ||
             shading_.affordable(below + kept.greatest_traced)) &&
            (kept.least_cut == no_price || !shading_.affordable(below + kept.least_cut));
        if (!holds) {
            trees_.remove(child);
            child = no_node;
        } else if (trees_.marks[child]) {
            walk(child, below);
        }
    }
    if (child == no_node) {
        ++kind;
        child = trees_.add();
        Node& fresh = trees_.nodes[child];
        fresh.origin = ray.origin;
        fresh.direction = ray.direction;
        fresh.parent = node;
        fresh.depth = static_cast<std::uint8_t>(trees_.nodes[node].depth + 1);
        trace_new(child, below);
    }
    Node& parent = trees_.nodes[node];
    const Node& branch = trees_.nodes[child];
    const auto price = static_cast<std::int32_t>(*own);
    parent.greatest_traced =
        std::max({parent.greatest_traced, price,
                  branch.greatest_traced == -no_price ? price : price + branch.greatest_traced});
    if (branch.least_cut != no_price)
        parent.least_cut = std::min(parent.least_cut, price + branch.least_cut);
    for (std::size_t l = 0; l < lights_.size(); ++l)
        trees_.columns[l][node] =
            shade::add_scaled(trees_.columns[l][node], share, trees_.columns[l][child]);
    parent.unscaled = shade::add_scaled(parent.unscaled, share, branch.unscaled);
    return child;
}

// ---- results
// -------------------------------------------------------------------------------------

V3f CellUpdate::radiance(NodeIndex root) const {
    V3d sum(trees_.nodes[root].unscaled);
    for (std::size_t l = 0; l < lights_.size(); ++l)
        sum += V3d(lights_[l].record.energy) * V3d(trees_.columns[l][root]);
    return V3f(sum);
}

shade::FirstHit CellUpdate::first_hit(NodeIndex root) const {
    for (NodeIndex n = root; n != no_node && trees_.nodes[n].hit; n = trees_.nodes[n].refracted) {
        const shade::VisiblePoint point = shading_.visible_point(ray_of(n), trees_.nodes[n].hit);
        if (!point.response.invisible) return shading_.first_hit(point, trees_.nodes[n].hit);
    }
    return {};
}

}  // namespace irt::update
