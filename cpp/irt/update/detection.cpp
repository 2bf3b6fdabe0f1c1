// SPDX-License-Identifier: Apache-2.0
// What of a cell's history an update concerns: detection by flags and masks, and the tests of
// what they flag.
#include <algorithm>
#include <limits>
#include <utility>

#include "irt/history/mask_scan.h"
#include "irt/math/bits.h"
#include "irt/mutant.h"
#include "irt/update/cell_update.h"

namespace irt::update {

using history::Column;
using history::HitBehind;
using history::KeptPoint;
using history::mark_fresh;
using history::mark_shade;
using history::mark_walk;
using history::no_node;
using history::no_path;
using history::no_point;
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
        const trace::HitName& seen = trees_.nodes[node].visible;
        if (plan_.rebound[seen.object])
            blame(node, film::CauseKind::Object, seen.object);
        else
            blame(node, film::CauseKind::Material, material_of(seen));
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
    const trace::HitName& was = trees_.nodes[node].visible;
    const bool left = meets(node) && plan_.geometry_changed[was.object];
    blame(node, film::CauseKind::Object, left || !hit ? was.object : hit.object);
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
        now = intersector_.occlusion_moving(ray, queries, lights_[light].rule());
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
        now = intersector_.occlusion(ray, queries, lights_[light].rule());
    }
    kept = now;
    if (now.depth == was.depth) return;
    ++counts_.changed;
    for (const std::uint32_t blocker : {now.blocker, was.blocker})
        if (blocker != trace::none && plan_.tint_changed[blocker])
            blame(node, film::CauseKind::Object, blocker);
    if (!lists_.causes.empty() && lists_.causes[trees_.sample_of(node)] == 0)
        blame(node, film::CauseKind::Shadow, 0);
    if (mutated(Mutant::union_without_shadows))
        trees_.marks[node] |= mark_walk;
    else
        mark(node, mark_walk);
    if (trees_.marks[node] & (mark_shade | mark_fresh)) return;
    ++counts_.rays.shadings;
    respond(seen, point, light);
}

}  // namespace irt::update
