// SPDX-License-Identifier: Apache-2.0
#include "irt/update/cell_update.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "irt/history/mask_scan.h"
#include "irt/math/bits.h"
#include "irt/mutant.h"

namespace irt::update {

using history::any_path;
using history::Column;
using history::HitBehind;
using history::KeptPoint;
using history::mark_fresh;
using history::mark_shade;
using history::mark_walk;
using history::no_node;
using history::no_path;
using history::no_point;
using history::no_price;
using history::Node;

namespace {

bool same(const trace::Hit& a, const trace::Hit& b) {
    return a.object == b.object && a.part == b.part && a.primitive == b.primitive &&
           a.piece == b.piece && same_bits(a.t, b.t) && same_bits(a.u, b.u) && same_bits(a.v, b.v);
}

/// Flagged records lie far apart: those of so many tests ahead are fetched.
constexpr std::size_t look_ahead = 8;

template <class T>
void prefetch(const T& record) {
    __builtin_prefetch(&record);
}

}  // namespace

UpdateCounts& UpdateCounts::operator+=(const UpdateCounts& other) {
    flagged += other.flagged;
    tested += other.tested;
    retraced += other.retraced;
    changed += other.changed;
    new_rays += other.new_rays;
    nodes_traversed += other.nodes_traversed;
    uncovered += other.uncovered;
    whole_scene += other.whole_scene;
    rays += other.rays;
    return *this;
}

void CellLists::clear() {
    flagged.clear();
    flagged_shadows.clear();
    masked.clear();
    walked.clear();
    combined.clear();
    std::fill(retraced.begin(), retraced.end(), 0);
}

CellUpdate::CellUpdate(const shade::Shading& shading, const trace::Intersector& intersector,
                       const Plan& plan, history::PathTable& table, history::RayTrees& trees,
                       CellLists& lists)
    : shading_(shading),
      intersector_(intersector),
      plan_(plan),
      table_(table),
      trees_(trees),
      lists_(lists),
      lights_(shading.scene().lights()) {
    lists_.clear();
}

void CellUpdate::trace_sample(const trace::Ray& primary) {
    const auto sample = static_cast<history::SampleIndex>(trees_.roots.size());
    const NodeIndex root = trees_.add_node();
    trees_.roots.push_back(root);
    Node& node = trees_.nodes[root];
    node.origin = primary.origin;
    node.direction = primary.direction;
    node.parent = history::root_bit | sample;
    ++counts_.rays.primary;
    trace_new(root, primary, 0, 0);
    combine();
}

void CellUpdate::settle(history::SampleIndex first, const history::RayTrees::End& end,
                        const Reach& reach) {
    if (reach.foreseen->lights_move()) return;
    const auto reached = [&](history::PathIndex path) {
        return path != no_path && table_.reaches(path, reach.regions);
    };
    if (std::any_of(trees_.paths.begin() + static_cast<std::ptrdiff_t>(end.nodes),
                    trees_.paths.end(), reached))
        return;
    for (const history::LightNodes& light : trees_.lights)
        if (light.casts_shadows &&
            std::any_of(light.paths.begin() + static_cast<std::ptrdiff_t>(end.points),
                        light.paths.end(), reached))
            return;
    std::vector<V3f> beyond;
    for (std::size_t c = 0; c <= lights_.size(); ++c) beyond.push_back(seen_beyond(c));
    trees_.settle(first, end, beyond);
}

// ---- detection (sections 2.3, 3.1, 4.2)

void CellUpdate::keep_lights() {
    std::vector<Column> columns;
    std::vector<history::LightNodes> nodes;
    columns.push_back(std::move(trees_.columns[0]));
    for (std::size_t l = 0; l < lights_.size(); ++l) {
        if (const std::optional<std::size_t> kept = plan_.kept_lights[l]) {
            columns.push_back(std::move(trees_.columns[1 + *kept]));
            nodes.push_back(std::move(trees_.lights[*kept]));
            trees_.lights[*kept].paths.clear();
            continue;
        }
        const std::size_t points = trees_.points.size();
        columns.emplace_back();
        columns.back().assign(points, history::Intensity());
        nodes.emplace_back(lights_[l].record.casts_shadows);
        if (!nodes.back().casts_shadows) continue;
        nodes.back().paths.assign(points, no_path);
        nodes.back().occlusions.resize(points);
    }
    for (const history::LightNodes& gone : trees_.lights)
        for (const history::PathIndex path : gone.paths) trees_.shadow_rays -= path != no_path;
    trees_.columns = std::move(columns);
    trees_.lights = std::move(nodes);
}

void CellUpdate::detect() {
    if (!plan_.regions.empty()) {
        if (plan_.geometry_differs)
            table_.for_each_flagged(trees_.paths, [&](std::size_t n) {
                lists_.flagged.push_back(static_cast<NodeIndex>(n));
            });
        for (std::uint32_t l = 0; l < lights_.size(); ++l)
            table_.for_each_flagged(trees_.lights[l].paths, [&](std::size_t p) {
                lists_.flagged_shadows.push_back({static_cast<PointIndex>(p), l});
            });
        if (without(Structure::shadow_records)) {
            lists_.flagged_shadows.clear();
            for (std::uint32_t l = 0; l < lights_.size(); ++l)
                for (PointIndex p = 0; p < trees_.lights[l].paths.size(); ++p)
                    if (trees_.lights[l].paths[p] != no_path)
                        lists_.flagged_shadows.push_back({p, l});
        }
        counts_.flagged += lists_.flagged.size() + lists_.flagged_shadows.size();
    }
    if (plan_.material_mask != 0) detect_materials();
}

/// Marks the points whose material changed, or whose object is bound to another.
void CellUpdate::detect_materials() {
    const bool all = without(Structure::material_mask);
    std::vector<PointIndex>& masked = lists_.masked;
    history::for_each_masked(trees_.material_bits, all ? ~std::uint64_t{0} : plan_.material_mask,
                             [&](std::size_t p) { masked.push_back(static_cast<PointIndex>(p)); });
    for (std::size_t i = 0; i < masked.size(); ++i) {
        if (i + 2 * look_ahead < masked.size()) fetch_point(masked[i + 2 * look_ahead]);
        if (i + look_ahead < masked.size()) {
            const KeptPoint& ahead = trees_.points[masked[i + look_ahead]];
            for (const NodeIndex node : {ahead.node, ahead.branches[0], ahead.branches[1]})
                if (node != no_node) prefetch(trees_.nodes[node]);
        }
        const NodeIndex node = trees_.points[masked[i]].node;
        if (!all) {
            const std::uint32_t object = trees_.nodes[node].visible.object;
            if (plan_.geometry_changed[object]) continue;  // its path is flagged, its point goes
            if (!plan_.rebound[object] &&
                !plan_.material_changed[material_of(trees_.nodes[node].visible)])
                continue;
            ++counts_.flagged;
        }
        mark(node, mark_shade);
        for (const NodeIndex branch : trees_.points[masked[i]].branches)
            if (branch != no_node && trees_.nodes[branch].point != no_point)
                fetch_point(trees_.nodes[branch].point);
    }
}

/// Fetches all that shading a point will read and write of it.
void CellUpdate::fetch_point(PointIndex point) const {
    prefetch(trees_.points[point]);
    for (std::size_t l = 0; l < lights_.size(); ++l) {
        prefetch(trees_.columns[1 + l][point]);
        if (!trees_.lights[l].casts_shadows) continue;
        prefetch(trees_.lights[l].paths[point]);
        prefetch(trees_.lights[l].occlusions[point]);
    }
}

std::uint32_t CellUpdate::material_of(const trace::HitName& visible) const {
    const Surface& surface = shading_.scene().surface(visible.object, visible.part);
    return surface.material_of(visible.primitive);
}

// ---- tests of what is flagged (sections 2.4, 4.1)

void CellUpdate::test() {
    const std::vector<NodeIndex>& nodes = lists_.flagged;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (i + look_ahead < nodes.size()) prefetch(trees_.nodes[nodes[i + look_ahead]]);
        if (trees_.paths[nodes[i]] != no_path)
            test_segment(nodes[i]);  // else it went with its root
    }
    const std::vector<CellLists::LightNodeIndex>& shadows = lists_.flagged_shadows;
    for (std::size_t i = 0; i < shadows.size(); ++i) {
        if (i + 2 * look_ahead < shadows.size()) {
            const auto& [point, light] = shadows[i + 2 * look_ahead];
            prefetch(trees_.points[point]);
            prefetch(trees_.lights[light].occlusions[point]);
        }
        if (i + look_ahead < shadows.size()) {
            const NodeIndex node = trees_.points[shadows[i + look_ahead].point].node;
            if (node != no_node) prefetch(trees_.nodes[node]);
        }
        const auto& [point, light] = shadows[i];
        if (trees_.lights[light].paths[point] != no_path) test_shadow(point, light);
    }
}

/// Recomputes a visible point from the history (section 2.4) where what changed may matter to it.
void CellUpdate::test_segment(NodeIndex index) {
    const Node& node = trees_.nodes[index];
    const trace::Ray ray = trees_.ray(index);
    trace::QueryCounts& queries = counts_.rays.queries;
    ++counts_.tested;
    const bool seen = node.point != no_point;
    if (!seen || !plan_.geometry_changed[node.visible.object]) {
        // Nothing that stayed hides it; what changed may.
        if (!plan_.arrivals.may_meet(V3d(ray.origin), V3d(ray.direction), node.t)) return;
        count_query(index);
        const trace::HitName was = node.visible;
        const trace::Hit limit = seen ? kept_hit(index) : trace::Hit();
        const trace::Hit now = without(Structure::dynamic_set)
                                   ? intersector_.nearest(ray, queries)
                                   : intersector_.nearest_moving(ray, limit, queries);
        if (same(now, limit)) return;
        HitBehind behind;
        if (!seen || !intersector_.moves(was.object))
            behind = {was, intersector_.epoch()};
        else if (record_holds(node.point))
            behind = trees_.behind[node.point];
        return replace_visible(index, now, behind);
    }
    ++counts_.uncovered;
    count_retraced(index);
    count_query(index);
    if (record_holds(node.point) && !without(Structure::dynamic_set)) {
        const HitBehind record = trees_.behind[node.point];
        const trace::Hit now = intersector_.nearest_moving(
            ray, trace::named_hit(shading_.scene(), ray, record.hit), queries);
        const bool used = now && now.object == record.hit.object;
        return replace_visible(index, now, used ? HitBehind() : record);
    }
    ++counts_.whole_scene;
    trace::Hit second;
    const trace::Hit now = intersector_.nearest_and_behind(ray, second, queries);
    replace_visible(index, now, {trace::HitName(second), intersector_.epoch()});
}

bool CellUpdate::record_holds(PointIndex point) const {
    const HitBehind& record = trees_.behind[point];
    if (without(Structure::intersection_history)) return false;
    if (mutated(Mutant::stale_record) && record.epoch == intersector_.epoch()) return true;
    if (mutated(Mutant::stale_epoch) && record.epoch != HitBehind::unknown)
        return record.hit.object == trace::none || !intersector_.moves(record.hit.object);
    return record.epoch == intersector_.epoch() &&
           (record.hit.object == trace::none || !intersector_.moves(record.hit.object));
}

/// Gives a node another visible point; what was kept of the old one's rays goes.
void CellUpdate::replace_visible(NodeIndex node, const trace::Hit& hit, const HitBehind& behind) {
    trees_.remove_point(node);
    trees_.set_hit(node, hit);
    if (hit) trees_.behind[trees_.nodes[node].point] = behind;
    const Node& ray = trees_.nodes[node];
    trees_.paths[node] = table_.intern(table_.grid().path(ray.origin, ray.direction, hit.t));
    ++counts_.changed;
    mark(node, mark_fresh);
}

/// Redoes a flagged shadow ray as far as what changed can matter to it.
void CellUpdate::test_shadow(PointIndex point, std::size_t light) {
    trace::Occlusion& kept = trees_.lights[light].occlusions[point];
    const trace::Occlusion was = kept;
    // An opaque blocker that stays keeps the point dark, whatever else moves (DESIGN 4, step 4).
    const bool blocked = was.blocker != trace::none;
    if (blocked && mutated(Mutant::blocker_kept)) return;
    const bool known = !without(Structure::shadow_records);
    if (blocked && !plan_.tint_changed[was.blocker] && known && !without(Structure::blocker_names))
        return;
    ++counts_.tested;
    // The segment, but for the rounding that the boxes allow for.
    const NodeIndex node = trees_.points[point].node;
    const Node& seen_from = trees_.nodes[node];
    const V3d from = V3d(seen_from.origin) + V3d(seen_from.direction) * seen_from.t;
    const V3d to_light = shade::Shading::towards(from, lights_[light]);
    const double t_end = lights_[light].record.kind == LightKind::Distant
                             ? std::numeric_limits<double>::infinity()
                             : 1.0;
    const bool arrives = plan_.shadowing.may_meet(from, to_light, t_end);
    const bool clear = !blocked && was.depth == trace::OpticalDepth{};
    if (known && !blocked && !arrives &&
        (clear || !plan_.tint_departed || !plan_.departures.may_meet(from, to_light, t_end)))
        return;
    const ShadePoint seen = shade_point_of(node);
    const trace::Ray ray = shading_.shadow_ray(seen, lights_[light]);
    trace::QueryCounts& queries = counts_.rays.queries;
    trace::Occlusion now;
    if (arrives && known && !without(Structure::dynamic_set)) {
        ++counts_.rays.shadow;
        now = intersector_.occlusion_moving(ray, queries);
    }
    // What the dynamic set alone darkens is dark. Where it is clear, and what left let no light
    // through, so that it was not there, all is as before; and where all was clear, what stays is
    // so still, unless it began to stop light.
    const bool moving_clear = now.depth == trace::OpticalDepth{};
    const bool moving_known = known && !without(Structure::dynamic_set);
    if (moving_known && !blocked && moving_clear && !plan_.tint_departed) return;
    const bool settled =
        moving_known && (now.blocker != trace::none || (clear && !plan_.still_tint_changed));
    if (!settled) {
        ++counts_.rays.shadow;
        count_retraced(node);
        now = intersector_.occlusion(ray, queries);
    }
    kept = now;
    if (now.depth == was.depth) return;
    ++counts_.changed;
    if (mutated(Mutant::union_without_shadows))
        trees_.marks[node] |= mark_walk;
    else
        mark(node, mark_walk);
    if (trees_.marks[node] & (mark_shade | mark_fresh)) return;
    ++counts_.rays.shadings;
    respond(seen, point, light);
}

// ---- the walk (sections 2.5, 3.2)

void CellUpdate::shade() {
    if (plan_.lights_moved || plan_.lights_reshaped) light_new_lights();
    if (without(Structure::cumulative_flags))
        for (NodeIndex n = 0; n < trees_.nodes.size(); ++n)
            if (trees_.paths[n] != no_path) mark(n, mark_walk);
    for (const history::SampleIndex sample : lists_.walked) walk(trees_.roots[sample], 0, 0);
}

/// Lights every point by the lights that are new, moved or shaped otherwise (section 4.1, case 2).
void CellUpdate::light_new_lights() {
    for (PointIndex p = 0; p < trees_.points.size(); ++p) {
        const NodeIndex node = trees_.points[p].node;
        if (node == no_node || (trees_.marks[node] & (mark_shade | mark_fresh))) continue;
        const ShadePoint point = shade_point_of(node);
        ++counts_.flagged;
        ++counts_.rays.shadings;
        for (std::size_t l = 0; l < lights_.size(); ++l)
            if (!plan_.kept_lights[l] || plan_.reshaped_lights[l]) respond(point, p, l);
        mark(node, mark_walk);
    }
}

void CellUpdate::walk(NodeIndex node, int depth, std::int64_t cost) {
    ++counts_.nodes_traversed;
    const std::uint8_t marks = std::exchange(trees_.marks[node], std::uint8_t{0});
    if (trees_.nodes[node].point == no_point) return;
    if (marks & (mark_shade | mark_fresh)) {
        shade_point(node, shade_point_of(node), depth, cost);
    } else {
        for (int which = 0; which < 2; ++which) {
            const KeptPoint& point = trees_.points[trees_.nodes[node].point];
            const NodeIndex branch = point.branches[which];
            if (branch != no_node && trees_.marks[branch])
                walk(branch, depth + 1, cost + point.prices[which]);
        }
    }
    lists_.combined.push_back(node);
}

/// Traces a node whose ray is `ray`, and everything below it (section 2.5). What was just written
/// to the node is handed on, not read back: stores that are still under way would be waited for.
void CellUpdate::trace_new(NodeIndex node, const trace::Ray& ray, int depth, std::int64_t cost) {
    count_new(node);
    trace::Hit behind;
    const trace::Hit hit = intersector_.nearest_and_behind(ray, behind, counts_.rays.queries);
    const history::Path path = table_.grid().path(ray.origin, ray.direction, hit.t);
    table_.fetch(path);
    trees_.set_hit(node, hit);
    if (hit) {
        trees_.behind[trees_.nodes[node].point] = {trace::HitName(behind), intersector_.epoch()};
        const double before = travelled(node, trace::HitName(hit));
        shade_point(node, shading_.visible_point(ray, hit, before), depth, cost);
        lists_.combined.push_back(node);
    }
    trees_.paths[node] = table_.intern(path);
}

/// Responds to the lights and spawns, as the node's visible point asks; keeps what holds of shadow
/// rays and branches.
void CellUpdate::shade_point(NodeIndex node, const ShadePoint& point, int depth,
                             std::int64_t cost) {
    const PointIndex at = trees_.nodes[node].point;
    ++counts_.rays.shadings;
    trees_.material_bits[at] = point.surface.material % 64;
    if (trees_.emits) trees_.columns[0][at].own = V3f(point.response().emission);
    for (std::size_t l = 0; l < lights_.size(); ++l) respond(point, at, l);
    trees_.points[at].own_cut = no_price;
    if (depth == shading_.max_depth()) return;
    const shade::Spawned rays = shading_.spawned(point);
    settle_branch(node, 0, point, rays.reflect_direction, rays.reflect_weight, depth, cost);
    settle_branch(node, 1, point, rays.refract_direction, rays.refract_weight, depth, cost);
}

/// The point's own response to a light. Its shadow ray is traced where none is kept.
void CellUpdate::respond(const ShadePoint& point, PointIndex at, std::size_t light) {
    V3f& own = trees_.columns[1 + light][at].own;
    const std::optional<shade::LightSample> sample = shading_.light_sample(point, lights_[light]);
    if (!sample || !sample->shadow_ray) trees_.set_shadow_path(light, at, no_path);
    if (!sample) {
        own = {0, 0, 0};
        return;
    }
    V3d response = sample->response;
    if (sample->shadow_ray) {
        if (trees_.lights[light].paths[at] == no_path) trace_shadow(*sample->shadow_ray, at, light);
        response *= shade::shadowed(lights_[light].record, trees_.lights[light].occlusions[at]);
    }
    own = V3f(response);
}

void CellUpdate::trace_shadow(const trace::Ray& ray, PointIndex at, std::size_t light) {
    ++counts_.rays.shadow;
    count_retraced(trees_.points[at].node);
    ++counts_.changed;
    const history::Path path =
        table_.grid().path(ray.origin, ray.direction, static_cast<double>(ray.t_max));
    table_.fetch(path);
    trees_.lights[light].occlusions[at] = intersector_.occlusion(ray, counts_.rays.queries);
    trees_.set_shadow_path(light, at, table_.intern(path));
}

/// The visible point of a node that has one, as the query gave it.
trace::Hit CellUpdate::kept_hit(NodeIndex index) const {
    const Node& node = trees_.nodes[index];
    const trace::HitName& name = node.visible;
    const Surface& surface = shading_.scene().surface(name.object, name.part);
    if (surface.triangles || surface.curves)
        return trace::named_hit(shading_.scene(), trees_.ray(index), name);
    trace::Hit hit;
    hit.t = node.t;
    hit.object = name.object;
    hit.part = name.part;
    hit.primitive = name.primitive;
    hit.piece = trees_.points[node.point].piece;
    return hit;
}

/// The lengths of the rays that led to this node's, summed from the root on as shade::Whitted does.
double CellUpdate::travelled(NodeIndex index) const {
    const NodeIndex parent = trees_.nodes[index].parent;
    if ((parent & history::root_bit) || mutated(Mutant::footprint_restarted)) return 0;
    return travelled(parent) + shade::Shading::length(trees_.ray(parent), trees_.nodes[parent].t);
}

/// One branch of `node`: kept, walked, traced anew or cut, as its weight and direction now say.
void CellUpdate::settle_branch(NodeIndex node, int which, const ShadePoint& point,
                               const V3d& direction, const V3d& weight, int depth,
                               std::int64_t cost) {
    const PointIndex at = trees_.nodes[node].point;
    const V3f share(weight);
    const std::optional<std::int64_t> price = shade::price(share);
    const bool traced = price && shading_.affordable(cost + *price);
    if (price && !traced)
        trees_.points[at].own_cut =
            std::min(trees_.points[at].own_cut, static_cast<std::int32_t>(*price));
    NodeIndex branch = trees_.points[at].branches[which];
    if (!traced && branch == no_node) return;
    const std::int64_t below = traced ? cost + *price : 0;
    const trace::Ray ray = traced ? shading_.spawned_ray(point, direction) : trace::Ray();
    if (branch != no_node && (!traced || !branch_holds(branch, ray, below))) {
        trees_.remove(branch);
        branch = no_node;
        if (!mutated(Mutant::node_reused)) trees_.points[at].branches[which] = no_node;
    }
    if (!traced) return;
    trees_.points[at].prices[which] = static_cast<std::int16_t>(*price);
    if (branch != no_node) {
        trees_.nodes[branch].weight = share;
        if (trees_.marks[branch]) walk(branch, depth + 1, below);
        return;
    }
    ++(which == 0 ? counts_.rays.reflected : counts_.rays.refracted);
    branch = trees_.add_node();
    trees_.points[at].branches[which] = branch;
    Node& fresh = trees_.nodes[branch];
    fresh.origin = ray.origin;
    fresh.direction = ray.direction;
    fresh.weight = share;
    fresh.parent = node;
    trace_new(branch, ray, depth + 1, below);
}

/// Whether a branch still has its ray, and the price of the way to it, `cost`, neither cuts what
/// was traced below it nor traces what was cut (DESIGN 3, rule 5).
bool CellUpdate::branch_holds(NodeIndex branch, const trace::Ray& ray, std::int64_t cost) const {
    const Node& kept = trees_.nodes[branch];
    const bool same_ray =
        same_bits(kept.origin, ray.origin) && same_bits(kept.direction, ray.direction);
    if (!same_ray && !mutated(Mutant::branch_ray_kept)) return false;
    if (kept.point == no_point || mutated(Mutant::cut_off_not_rewalked)) return true;
    const KeptPoint& point = trees_.points[kept.point];
    return (point.greatest_traced == -no_price ||
            shading_.affordable(cost + point.greatest_traced)) &&
           (point.least_cut == no_price || !shading_.affordable(cost + point.least_cut));
}

// ---- combining (section 3.2)

void CellUpdate::combine() {
    for (const NodeIndex node : lists_.combined) combine_node(node);
    lists_.combined.clear();
}

/// A node's cumulative intensity: its point's own and that of each branch, weighted.
void CellUpdate::combine_node(NodeIndex node) {
    const PointIndex at = trees_.nodes[node].point;
    KeptPoint& point = trees_.points[at];
    point.greatest_traced = -no_price;
    point.least_cut = point.own_cut;
    const Node* branches[2];
    int count = 0;
    for (int which = 0; which < 2; ++which) {
        if (point.branches[which] == no_node) continue;
        const Node& branch = trees_.nodes[point.branches[which]];
        const std::int32_t price = point.prices[which];
        branches[count++] = &branch;
        point.greatest_traced = std::max(point.greatest_traced, price);
        if (branch.point == no_point) continue;
        const KeptPoint& below = trees_.points[branch.point];
        if (below.greatest_traced != -no_price)
            point.greatest_traced = std::max(point.greatest_traced, price + below.greatest_traced);
        if (below.least_cut != no_price)
            point.least_cut = std::min(point.least_cut, price + below.least_cut);
    }
    for (std::size_t c = trees_.emits ? 0 : 1; c < trees_.columns.size(); ++c) {
        Column& column = trees_.columns[c];
        V3f sum = column[at].own;
        for (int b = 0; b < count; ++b) {
            const V3f below = branches[b]->point == no_point
                                  ? seen_beyond(c)
                                  : column[branches[b]->point].cumulative;
            sum = shade::add_scaled(sum, branches[b]->weight, below);
        }
        column[at].cumulative = sum;
    }
}

// ---- counts and results

/// Marks a node and the way to its root.
void CellUpdate::mark(NodeIndex node, std::uint8_t what) {
    if (trees_.mark(node, what)) lists_.walked.push_back(trees_.sample_of(node));
}

void CellUpdate::count_retraced(NodeIndex node) {
    ++counts_.retraced;
    if (!lists_.retraced.empty()) ++lists_.retraced[trees_.sample_of(node)];
}

/// A ray that was not there: flagged, retraced and changed by that.
void CellUpdate::count_new(NodeIndex node) {
    ++counts_.new_rays;
    ++counts_.flagged;
    ++counts_.changed;
    count_retraced(node);
}

/// A query for a node's ray that was there.
void CellUpdate::count_query(NodeIndex node) {
    const NodeIndex parent = trees_.nodes[node].parent;
    if (parent & history::root_bit)
        ++counts_.rays.primary;
    else if (trees_.points[trees_.nodes[parent].point].branches[0] == node)
        ++counts_.rays.reflected;
    else
        ++counts_.rays.refracted;
}

/// What a ray that meets nothing sees, of a column.
V3f CellUpdate::seen_beyond(std::size_t column) const {
    return column == 0 ? V3f(0, 0, 0) : shade::seen_beyond(lights_[column - 1].record);
}

V3f CellUpdate::radiance(history::SampleIndex sample) const {
    const std::uint32_t root = trees_.roots[sample];
    const bool settled = (root & history::settled_bit) != 0;
    const std::uint32_t at = settled ? root & ~history::settled_bit : trees_.nodes[root].point;
    const auto cumulative = [&](std::size_t column) {
        if (!settled && at == no_point) return V3d(seen_beyond(column));
        return V3d(settled ? trees_.settled[column][at] : trees_.columns[column][at].cumulative);
    };
    V3d sum = trees_.emits ? cumulative(0) : V3d(0, 0, 0);
    for (std::size_t l = 0; l < lights_.size(); ++l)
        sum += V3d(lights_[l].record.energy) * cumulative(1 + l);
    if (mutated(Mutant::energy_rescaled) && plan_.lights_differ)  // as if it had been 0.7 of it
        return V3f(V3d(V3f(sum * 0.7)) / 0.7);
    return V3f(sum);
}

shade::FirstHit CellUpdate::first_hit(history::SampleIndex sample, bool surface) const {
    NodeIndex node = trees_.roots[sample];
    while (node != no_node && trees_.nodes[node].point != no_point) {
        const trace::HitName& visible = trees_.nodes[node].visible;
        const std::uint32_t material = material_of(visible);
        const bool varies = shading_.varies(material);
        if (surface || varies) {
            const ShadePoint point = shade_point_of(node);
            if (!point.response().invisible)
                return surface ? shading_.first_hit(point, visible.object) : shade::FirstHit{true};
        } else if (!shading_.response(material).invisible) {
            return shade::FirstHit{true};
        }
        node = trees_.points[trees_.nodes[node].point].branches[1];
    }
    return {};
}

}  // namespace irt::update
