// SPDX-License-Identifier: Apache-2.0
#include "irt/update/cell_update.h"

#include <algorithm>
#include <utility>

#include "irt/math/bits.h"
#include "irt/mutant.h"
#include "irt/shade/fresh_stack.h"

namespace irt::update {

using history::Column;
using history::KeptPoint;
using history::mark_fresh;
using history::mark_shade;
using history::mark_walk;
using history::no_node;
using history::no_path;
using history::no_point;
using history::no_price;
using history::Node;

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
    std::fill(causes.begin(), causes.end(), film::CauseCode{0});
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
    trees_.settle(first, end,
                  [&](std::size_t column, NodeIndex node) { return seen_beyond(column, node); });
}

// ---- the walk (sections 2.5, 3.2)

void CellUpdate::shade() {
    if (plan_.lights_moved || plan_.lights_reshaped) light_new_lights();
    if (plan_.skies_differ) see_other_skies();
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
            if (!plan_.kept_lights[l] || plan_.reshaped_lights[l]) {
                respond(point, p, l);
                blame(node, film::CauseKind::Light, change_of_light(l));
            }
        mark(node, mark_walk);
    }
}

/// Has all nodes combined again that a branch which meets nothing joins; nothing is traced.
void CellUpdate::see_other_skies() {
    for (NodeIndex n = 0; n < trees_.nodes.size(); ++n) {
        const Node& node = trees_.nodes[n];
        if (trees_.paths[n] != no_path && node.point == no_point &&
            !(node.parent & history::root_bit))
            mark(trees_.parent(n), mark_walk);
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
                shade::with_stack_for(depth + 1, [&, price = point.prices[which]] {
                    walk(branch, depth + 1, cost + price);
                });
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
    trees_.lights[light].occlusions[at] =
        intersector_.occlusion(ray, counts_.rays.queries, lights_[light].rule());
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
    if (trees_.is_root(index) || mutated(Mutant::footprint_restarted)) return 0;
    const NodeIndex parent = trees_.parent(index);
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
        if (trees_.marks[branch])
            shade::with_stack_for(depth + 1, [&] { walk(branch, depth + 1, below); });
        return;
    }
    ++(which == 0 ? counts_.rays.reflected : counts_.rays.refracted);
    branch = trees_.add_node();
    trees_.points[at].branches[which] = branch;
    Node& fresh = trees_.nodes[branch];
    fresh.origin = ray.origin;
    fresh.direction = ray.direction;
    fresh.weight = share;
    fresh.parent = ray.camera ? node | history::camera_bit : node;
    shade::with_stack_for(depth + 1, [&] { trace_new(branch, ray, depth + 1, below); });
}

/// Whether a branch still has its ray, and the price of the way to it, `cost`, neither cuts what
/// was traced below it nor traces what was cut (DESIGN 3, rule 5).
bool CellUpdate::branch_holds(NodeIndex branch, const trace::Ray& ray, std::int64_t cost) const {
    const Node& kept = trees_.nodes[branch];
    const bool same_ray = same_bits(kept.origin, ray.origin) &&
                          same_bits(kept.direction, ray.direction) &&
                          trees_.ray(branch).camera == ray.camera;
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
    NodeIndex branches[2];
    int count = 0;
    for (int which = 0; which < 2; ++which) {
        if (point.branches[which] == no_node) continue;
        const Node& branch = trees_.nodes[point.branches[which]];
        const std::int32_t price = point.prices[which];
        branches[count++] = point.branches[which];
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
            const Node& branch = trees_.nodes[branches[b]];
            const V3f below = branch.point == no_point ? seen_beyond(c, branches[b])
                                                       : column[branch.point].cumulative;
            sum = shade::add_scaled(sum, branch.weight, below);
        }
        column[at].cumulative = sum;
    }
}

// ---- counts and results

/// Marks a node and the way to its root.
void CellUpdate::mark(NodeIndex node, std::uint8_t what) {
    if (trees_.mark(node, what)) lists_.walked.push_back(trees_.sample_of(node));
}

void CellUpdate::blame(NodeIndex node, film::CauseKind kind, std::uint32_t index) {
    if (lists_.causes.empty()) return;
    film::CauseCode& known = lists_.causes[trees_.sample_of(node)];
    const film::CauseCode cause = film::make_cause(kind, index);
    if (known == 0 || cause < known) known = cause;
}

/// The place of a light among those that changed; if it did not, that of the first.
std::uint32_t CellUpdate::change_of_light(std::size_t light) const {
    const auto found = std::find(plan_.changed_lights.begin(), plan_.changed_lights.end(), light);
    return found == plan_.changed_lights.end()
               ? 0
               : static_cast<std::uint32_t>(found - plan_.changed_lights.begin());
}

bool CellUpdate::responds(history::SampleIndex sample, std::size_t light) const {
    const std::uint32_t root = trees_.roots[sample];
    if (root & history::settled_bit)
        return trees_.settled[1 + light][root & ~history::settled_bit] != V3f(0, 0, 0);
    return cumulative(root, 1 + light) != V3f(0, 0, 0);
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
    if (trees_.is_root(node))
        ++counts_.rays.primary;
    else if (trees_.points[trees_.nodes[trees_.parent(node)].point].branches[0] == node)
        ++counts_.rays.reflected;
    else
        ++counts_.rays.refracted;
}

/// What the ray of a node that meets nothing sees, of a column.
V3f CellUpdate::seen_beyond(std::size_t column, NodeIndex node) const {
    if (column == 0 || lights_[column - 1].record.kind != LightKind::Environment) return {0, 0, 0};
    return shading_.seen_beyond(lights_[column - 1], trees_.ray(node));
}

V3f CellUpdate::part(history::SampleIndex sample, const shade::ResolvedPart& part) const {
    const std::uint32_t root = trees_.roots[sample];
    if ((root & history::settled_bit) == 0) return shade::part_of(part, *this, root, lights_);
    const std::uint32_t at = root & ~history::settled_bit;
    V3d sum(0, 0, 0);
    if (part.columns[0] && trees_.emits) sum += V3d(trees_.settled[0][at]);
    for (std::size_t l = 0; l < lights_.size(); ++l)
        if (part.columns[1 + l])
            sum += V3d(lights_[l].record.energy) * V3d(trees_.settled[1 + l][at]);
    return V3f(sum);
}

/// Whether some of what a node's ray carries goes by its surface.
bool CellUpdate::passes(Handle node) const {
    const trace::HitName& visible = trees_.nodes[node].visible;
    const std::uint32_t material = material_of(visible);
    if (!shading_.varies(material) && !shading_.scene().matte(visible.object, visible.part))
        return shading_.response(material).presence < 1;
    return shade_point_of(node).response().presence < 1;
}

V3f CellUpdate::radiance(history::SampleIndex sample) const {
    const std::uint32_t root = trees_.roots[sample];
    const bool settled = (root & history::settled_bit) != 0;
    const std::uint32_t at = settled ? root & ~history::settled_bit : trees_.nodes[root].point;
    const auto cumulative = [&](std::size_t column) {
        if (!settled && at == no_point) return V3d(seen_beyond(column, root));
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
            const trace::Hit hit = kept_hit(node);
            const ShadePoint point =
                shading_.visible_point(trees_.ray(node), hit, travelled(node, visible));
            if (!point.response().invisible()) return shade::Shading::first_hit(point, hit);
        } else if (!shading_.response(material).invisible()) {
            shade::FirstHit named;
            named.seen.object = visible.object;
            named.seen.part = visible.part;
            named.seen.primitive = visible.primitive;
            named.material = material;
            named.matte = shading_.scene().matte(visible.object, visible.part);
            return named;
        }
        node = trees_.points[trees_.nodes[node].point].branches[1];
    }
    return {};
}

}  // namespace irt::update
