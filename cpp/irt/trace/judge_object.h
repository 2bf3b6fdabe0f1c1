// SPDX-License-Identifier: Apache-2.0
// All primitives of an object before their scalar judges: for what has no trees.
#pragma once

#include "irt/scene/scene.h"
#include "irt/trace/judge_primitive.h"

namespace irt::trace {

/// Calls found(hit) for every primitive of `surface` that `ray`, in its trace space, meets within
/// its limits. True once it says so. `named`: object and part.
template <class Found>
bool judge_surface(const Surface& surface, const JudgeRay& ray, const Hit& named, Found&& found) {
    const std::uint32_t primitives = primitive_count(surface);
    for (std::uint32_t k = 0; k < primitives; ++k) {
        Hit hit = named;
        if (judge_primitive(surface, k, ray, hit) && found(hit)) return true;
    }
    return false;
}

/// Whether rays, of the camera or not, meet what has this role.
inline bool meets(bool camera, const PassRole& role) { return !camera || role.camera_visible; }

template <class Found>
bool judge_prototype(const CompiledPrototype& prototype, const JudgeRay& ray, bool camera,
                     Hit named, Found&& found) {
    const std::uint32_t first = named.part;
    for (const Surface& surface : prototype.surfaces) {
        if (meets(camera, surface.role) && judge_surface(surface, ray, named, found)) return true;
        ++named.part;
    }
    for (const NestedArray& array : prototype.arrays)
        for (std::uint32_t entry = 0; entry < array.record->size(); ++entry) {
            JudgeRay local;
            transform_ray(inverse_of(array.outer_from_prototype(entry)), ray, local);
            named.part = first + array.first_part + entry * array.stride;
            if (meets(camera, array.role) &&
                judge_prototype(array.prototype(entry), local, camera, named, found))
                return true;
        }
    return false;
}

/// Calls found(hit) for every primitive of a live object that `ray`, in render space, meets within
/// its limits. True once it says so. `camera`: as in Ray.
template <class Found>
bool judge_object(const Scene& scene, std::uint32_t slot, const JudgeRay& ray, bool camera,
                  Found&& found) {
    if (!meets(camera, scene.object(slot).record.role)) return false;
    Hit named;
    named.object = slot;
    const CompiledPrototype* prototype = scene.prototype(slot);
    if (!prototype) return judge_surface(scene.object(slot).surface, ray, named, found);
    JudgeRay local;
    transform_ray(scene.prototype_from_render(slot), ray, local);
    return judge_prototype(*prototype, local, camera, named, found);
}

}  // namespace irt::trace
