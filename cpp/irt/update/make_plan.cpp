// SPDX-License-Identifier: Apache-2.0
#include "irt/update/make_plan.h"

#include <algorithm>
#include <utility>

#include "irt/scene/equality.h"
#include "irt/update/footprint.h"

namespace irt::update {

namespace {

/// Object slots that show one of `materials`.
std::vector<std::uint32_t> showing(const Scene& scene,
                                   const std::vector<std::uint32_t>& materials) {
    std::vector<std::uint32_t> slots;
    if (materials.empty()) return slots;
    const auto shows = [&](const std::vector<std::uint32_t>& shown) {
        return std::any_of(shown.begin(), shown.end(), [&](std::uint32_t material) {
            return std::count(materials.begin(), materials.end(), material) > 0;
        });
    };
    for (const ObjectSlot& object : scene.all_objects()) {
        if (!object.live) continue;
        if (!object.array) {
            if (shows(materials_of(object))) slots.push_back(object.slot);
            continue;
        }
        std::vector<bool> showing;
        for (const auto& prototype : object.prototypes)
            showing.push_back(shows(prototype->materials));
        if (std::count(showing.begin(), showing.end(), true) == 0) continue;
        for (const std::uint32_t slot : scene.entry_slots(object))
            if (showing[object.array->prototype(scene.entry(slot))]) slots.push_back(slot);
    }
    return slots;
}

/// Whether some part of `object` is not opaque, or fades in a light's shadows. Of an object that
/// was replaced: by the materials in force now; where one of those changed its tint the plan says
/// so anyway.
bool lets_light_through(const Scene& scene, const ObjectSlot& object) {
    if (std::any_of(scene.lights().begin(), scene.lights().end(), [](const LightSlot& light) {
            return light.rule() && light.rule()->falloff > 0;
        }))
        return true;
    const std::vector<std::uint32_t> shown = materials_of(object);
    return std::any_of(shown.begin(), shown.end(), [&](std::uint32_t slot) {
        const MaterialSlot& material = scene.materials()[slot];
        const auto& depth = material.shadow_depth.rgb;
        return material.tint_varies ||
               std::any_of(std::begin(depth), std::end(depth),
                           [](std::uint32_t d) { return d < trace::depth_opaque; });
    });
}

/// Live slots of the objects that one of two sets has and the other has not.
std::vector<std::uint32_t> differing(const Scene& scene, const std::vector<bool>& before,
                                     const std::vector<bool>& now) {
    std::vector<std::uint32_t> slots;
    if (before == now) return slots;
    for (std::uint32_t slot = 0; slot < scene.slot_count(); ++slot) {
        const std::uint32_t object = scene.object_index(slot);
        const bool was = object < before.size() && before[object];
        const bool is = object < now.size() && now[object];
        if (was != is && scene.live(slot)) slots.push_back(slot);
    }
    return slots;
}

std::vector<bool> shadowless(const LightSlot& light) {
    return light.rule() ? light.rule()->shadowless : std::vector<bool>();
}

/// Slots of the objects that a light lights now and did not, or the other way round, and of those
/// that cast its shadows now and did not, likewise.
struct Relinked {
    std::vector<std::uint32_t> lit, casting;
};

/// By light, its place before, if it casts the same rays as then; and what the others ask for.
Relinked compare_lights(const Scene& scene, const std::vector<LightSlot>& old_lights, Plan& plan) {
    Relinked relinked;
    const auto add = [](std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& slots) {
        to.insert(to.end(), slots.begin(), slots.end());
    };
    for (const LightSlot& light : scene.lights()) {
        const auto before =
            std::find_if(old_lights.begin(), old_lights.end(), [&](const LightSlot& old) {
                return old.path == light.path && same_rays(old.record, light.record);
            });
        const bool kept = before != old_lights.end();
        const bool sky = light.record.kind == LightKind::Environment;
        plan.kept_lights.emplace_back();
        plan.reshaped_lights.push_back(kept && !same_response(before->record, light.record));
        plan.lights_reshaped = plan.lights_reshaped || plan.reshaped_lights.back();
        if (const std::size_t place = plan.kept_lights.size() - 1;
            mutated(Mutant::lights_by_place) && place < old_lights.size())
            plan.kept_lights.back() = place;
        else if (kept)
            plan.kept_lights.back() = static_cast<std::size_t>(before - old_lights.begin());
        else if (!sky)
            plan.lights_moved = true;
        if (sky)
            plan.skies_differ =
                plan.skies_differ || !kept || !same_sky(before->record, light.record);
        if (!kept) continue;
        add(relinked.lit, differing(scene, before->unlit, light.unlit));
        add(relinked.casting, differing(scene, shadowless(*before), shadowless(light)));
    }
    return relinked;
}

}  // namespace

void Boxes::add(const trace::Box& box, double slack) {
    if (box.empty()) return;
    const trace::Box larger{box.lower - V3d(slack), box.upper + V3d(slack)};
    merged_ = merged_ || boxes_.size() == few;
    if (!merged_) return boxes_.push_back(larger);
    for (std::size_t i = 1; i < boxes_.size(); ++i) boxes_[0].extend(boxes_[i]);
    boxes_.resize(1);
    boxes_[0].extend(larger);
}

bool Boxes::may_meet(const V3d& origin, const V3d& direction, double t_end) const {
    if (without(Structure::segment_test)) return true;
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const trace::Box& box) {
        double enter = 0, exit = t_end;
        return trace::clip(box, origin, direction, enter, exit);
    });
}

std::vector<trace::Box> former_boxes(const trace::Intersector& intersector,
                                     const AppliedChanges& applied) {
    std::vector<trace::Box> boxes;
    const auto add = [&](const trace::Box& box) {
        if (!box.empty()) boxes.push_back(box);
    };
    for (const ObjectSlot& object : applied.previous) add(intersector.box(object.slot));
    for (const FormerEntries& former : applied.former)
        for (const std::uint32_t entry : former.entries)
            add(intersector.box(former.array.prototype_of(entry),
                                former.array.render_from_entry(entry)));
    return boxes;
}

Plan make_plan(const Scene& scene, const trace::Intersector& intersector,
               const history::VoxelGrid& grid, const AppliedChanges& applied,
               const std::vector<trace::Box>& old_boxes, const std::vector<LightSlot>& old_lights) {
    Plan plan;
    plan.geometry_changed.resize(scene.slot_count());
    plan.tint_changed.resize(scene.slot_count());
    plan.rebound.resize(scene.slot_count());
    plan.material_changed.resize(scene.materials().size());
    const double slack = intersector.pad();
    plan.lights_differ = !applied.lights.empty();
    for (const std::string& path : applied.lights) {
        const auto found = std::find_if(scene.lights().begin(), scene.lights().end(),
                                        [&](const LightSlot& light) { return light.path == path; });
        plan.changed_lights.emplace_back();
        if (found != scene.lights().end())
            plan.changed_lights.back() = static_cast<std::size_t>(found - scene.lights().begin());
    }
    const Relinked relinked = compare_lights(scene, old_lights, plan);
    plan.tint_departed =
        !applied.tints.empty() || !applied.retinted.empty() || !relinked.casting.empty();
    std::size_t former = applied.previous.size();
    for (const FormerEntries& array : applied.former) former += array.entries.size();
    Footprints footprints(grid, applied.geometry.size() + former);

    for (const std::uint32_t slot : applied.geometry) {
        plan.geometry_changed[slot] = plan.tint_changed[slot] = true;
        plan.arrivals.add(intersector.box(slot), slack);
        plan.shadowing.add(intersector.box(slot), slack);
        footprints.add(scene, slot);
    }
    plan.geometry_differs = !applied.geometry.empty();
    for (const trace::Box& box : old_boxes) plan.departures.add(box, slack);
    for (const ObjectSlot& object : applied.previous) {
        plan.tint_departed = plan.tint_departed || lets_light_through(scene, object);
        if (!mutated(Mutant::ghost_ignored)) footprints.add(object);
    }
    for (const FormerEntries& array : applied.former) {
        plan.tint_departed = plan.tint_departed || lets_light_through(scene, array.array);
        if (!mutated(Mutant::ghost_ignored)) footprints.add(array);
    }

    std::vector<std::uint32_t> tinted = showing(scene, applied.tints);
    tinted.insert(tinted.end(), applied.retinted.begin(), applied.retinted.end());
    tinted.insert(tinted.end(), relinked.casting.begin(), relinked.casting.end());
    for (const std::uint32_t slot : tinted) {
        plan.tint_changed[slot] = true;
        if (plan.geometry_changed[slot]) continue;
        plan.still_tint_changed = true;
        plan.shadowing.add(intersector.box(slot), slack);
        footprints.add(scene, slot);
    }
    plan.regions = footprints.regions();

    for (const std::uint32_t slot : applied.materials) {
        plan.material_mask |= std::uint64_t{1} << slot % 64;
        plan.material_changed[slot] = true;
    }
    for (const std::uint32_t slot : applied.unbound)
        plan.material_mask |= std::uint64_t{1} << slot % 64;
    for (const std::uint32_t slot : applied.rebound)
        plan.rebound[slot] = !mutated(Mutant::rebound_ignored);
    if (mutated(Mutant::mask_bit_dropped)) plan.material_mask &= plan.material_mask - 1;
    if (mutated(Mutant::tint_departed_ignored)) plan.tint_departed = false;
    if (mutated(Mutant::still_tint_ignored)) plan.still_tint_changed = false;

    for (const std::uint32_t slot : relinked.lit) {
        plan.rebound[slot] = true;
        plan.material_mask = ~std::uint64_t{0};
    }
    return plan;
}

}  // namespace irt::update
