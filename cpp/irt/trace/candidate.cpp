// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/candidate.h"

#include "irt/trace/intersector.h"

namespace irt::trace {

OpticalDepth local_tint(const Scene& scene, const MaterialSlot& material, const Surface& surface,
                        const Ray& ray, const Hit& hit) {
    graph::Site site{scene, surface, hit};
    if (!material.tint_reads_place) return graph::tint_at(material, site);
    const SurfacePoint point = surface_point(scene, ray, hit);
    const graph::Place place(scene, hit, point.position, point.shading_normal, V3d(ray.direction),
                             V3d(0), V3d(0));
    site.place = &place;
    return graph::tint_at(material, site);
}

}  // namespace irt::trace
