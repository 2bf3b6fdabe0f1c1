// SPDX-License-Identifier: Apache-2.0
#include "irt/update/make_plan.h"

#include <algorithm>
#include <utility>

#include "irt/scene/equality.h"

namespace irt::update {

namespace {

/// Whether light `b` casts the very rays that `a` cast.
bool same_rays(const LightSlot& a, const LightSlot& b) {
    Light other = b.record;
    other.energy = a.record.energy;
    return a.path == b.path && same(a.record, other);
}

/// Object slots that show one of `materials`.
std::vector<std::uint32_t> showing(const Scene& scene,
                                   const std::vector<std::uint32_t>& materials) {
    std::vector<std::uint32_t> slots;
    if (materials.empty()) return slots;
    for (std::uint32_t slot = 0; slot < scene.objects().size(); ++slot) {
        const ObjectSlot& object = scene.objects()[slot];
        if (!object.live) continue;
        const std::size_t parts = object.prototype ? object.prototype->surfaces.size() : 1;
        for (std::uint32_t part = 0; part < parts; ++part)
            if (std::count(materials.begin(), materials.end(), object.part(part).material)) {
                slots.push_back(slot);
                break;
            }
    }
    return slots;
}

}  // namespace

std::vector<trace::Box> footprints(const trace::Intersector& intersector,
                                   const std::vector<std::uint32_t>& slots) {
    std::vector<trace::Box> boxes;
    for (const std::uint32_t slot : slots) {
        const trace::Box box = intersector.box(slot);
        if (!box.empty()) boxes.push_back(box);
    }
    return boxes;
}

Plan make_plan(const Scene& scene, const trace::Intersector& intersector,
               const AppliedChanges& applied, std::vector<trace::Box> old_footprints,
               const std::vector<LightSlot>& old_lights) {
    Plan plan;
    plan.geometry_changed.resize(scene.objects().size());
    plan.tint_changed.resize(scene.objects().size());
    const auto add_arrivals = [&](const std::vector<std::uint32_t>& slots) {
        const std::vector<trace::Box> boxes = footprints(intersector, slots);
        plan.arrivals.insert(plan.arrivals.end(), boxes.begin(), boxes.end());
    };

    for (const std::uint32_t slot : applied.geometry)
        plan.geometry_changed[slot] = plan.tint_changed[slot] = true;
    add_arrivals(applied.geometry);

    for (const std::uint32_t slot : applied.materials) plan.material_mask |= 1ull << slot % 64;
    std::vector<std::uint32_t> tinted = showing(scene, applied.tints);
    tinted.insert(tinted.end(), applied.retinted.begin(), applied.retinted.end());
    for (const std::uint32_t slot : tinted) {
        plan.tint_changed[slot] = true;
        plan.still_tint_changed = plan.still_tint_changed || !plan.geometry_changed[slot];
    }
    add_arrivals(tinted);
    plan.regions = std::move(old_footprints);
    plan.regions.insert(plan.regions.end(), plan.arrivals.begin(), plan.arrivals.end());

    if (!applied.rebound.empty()) plan.rebound.resize(scene.objects().size());
    for (const std::uint32_t slot : applied.rebound) plan.rebound[slot] = true;

    plan.lights_differ = !applied.lights.empty();
    for (const LightSlot& light : scene.lights()) {
        const auto before =
            std::find_if(old_lights.begin(), old_lights.end(),
                         [&](const LightSlot& old) { return same_rays(old, light); });
        plan.kept_lights.emplace_back();
        if (before != old_lights.end())
            plan.kept_lights.back() = static_cast<std::size_t>(before - old_lights.begin());
        else
            plan.lights_moved = true;
    }
    return plan;
}

}  // namespace irt::update
