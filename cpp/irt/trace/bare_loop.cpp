// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/bare_loop.h"

#include <chrono>
#include <map>
#include <vector>

#include "irt/trace/embree.h"
#include "irt/trace/judge_primitive.h"
#include "irt/trace/trees.h"

namespace irt::trace {
namespace {

void bare_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& surface = *static_cast<const Surface*>(arguments->geometryUserPtr);
    const Box box = primitive_box(surface, arguments->primID);
    const V3f centre(box.lower * 0.5 + box.upper * 0.5);
    const V3f half((box.upper - box.lower) * (0.5 + 1e-5));
    RTCBounds& out = *arguments->bounds_o;
    out.lower_x = centre.x - half.x;
    out.lower_y = centre.y - half.y;
    out.lower_z = centre.z - half.z;
    out.upper_x = centre.x + half.x;
    out.upper_y = centre.y + half.y;
    out.upper_z = centre.z + half.z;
}

bool bare_judge(const void* user, unsigned primitive, const RTCRay& ray, Hit& hit) {
    const auto& surface = *static_cast<const Surface*>(user);
    JudgeRay judged;
    const float values[] = {ray.org_x, ray.org_y, ray.org_z, ray.dir_x, ray.dir_y, ray.dir_z};
    for (int a = 0; a < 3; ++a) {
        judged.origin[a] = static_cast<double>(values[a]);
        judged.direction[a] = static_cast<double>(values[3 + a]);
    }
    judged.t_max = static_cast<double>(ray.tfar);
    return judge_solid(surface, primitive, judged, hit);
}

void bare_intersect(const RTCIntersectFunctionNArguments* arguments) {
    auto& ray = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
    Hit hit;
    if (!bare_judge(arguments->geometryUserPtr, arguments->primID, ray.ray, hit)) return;
    ray.ray.tfar = static_cast<float>(hit.t);
    ray.hit.geomID = arguments->geomID;
    ray.hit.primID = arguments->primID;
}

void bare_occluded(const RTCOccludedFunctionNArguments* arguments) {
    auto& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
    Hit hit;
    if (bare_judge(arguments->geometryUserPtr, arguments->primID, ray, hit))
        ray.tfar = -std::numeric_limits<float>::infinity();
}

RTCRay bare_ray(const Ray& ray) {
    RTCRay out;
    out.org_x = ray.origin.x;
    out.org_y = ray.origin.y;
    out.org_z = ray.origin.z;
    out.tnear = 0;
    out.dir_x = ray.direction.x;
    out.dir_y = ray.direction.y;
    out.dir_z = ray.direction.z;
    out.time = 0;
    out.tfar = ray.t_max;
    out.mask = ~0u;
    out.id = 0;
    out.flags = 0;
    return out;
}

template <class Shoot>
LoopTime timed(std::span<const Ray> rays, Shoot&& shoot) {
    LoopTime time;
    const auto start = std::chrono::steady_clock::now();
    for (const Ray& ray : rays) time.hits += shoot(ray) ? 1 : 0;
    time.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return time;
}

}  // namespace

struct BareLoop::Impl {
    DeviceHandle device;
    TreeHandle tree;
    std::map<const CompiledPrototype*, TreeHandle> prototypes;

    TreeHandle new_tree() const {
        TreeHandle made(rtcNewScene(device.get()));
        rtcSetSceneFlags(made.get(), RTC_SCENE_FLAG_ROBUST);
        return made;
    }

    void attach(RTCScene to, GeometryHandle geometry) const {
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(to, geometry.get());
    }

    void add(RTCScene to, const Surface& surface) const {
        if (!surface.triangles) {
            GeometryHandle geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER));
            rtcSetGeometryUserPrimitiveCount(geometry.get(), primitive_count(surface));
            rtcSetGeometryUserData(geometry.get(), const_cast<Surface*>(&surface));
            rtcSetGeometryBoundsFunction(geometry.get(), bare_bounds, nullptr);
            rtcSetGeometryIntersectFunction(geometry.get(), bare_intersect);
            rtcSetGeometryOccludedFunction(geometry.get(), bare_occluded);
            return attach(to, std::move(geometry));
        }
        const Triangles& mesh = *surface.triangles;
        if (mesh.triangles.empty()) return;
        GeometryHandle geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        auto* points = static_cast<V3f*>(
            rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(V3f), mesh.points.size()));
        std::copy(mesh.points.begin(), mesh.points.end(), points);
        auto* triangles = static_cast<std::array<std::uint32_t, 3>*>(
            rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(std::uint32_t), mesh.triangles.size()));
        std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
        attach(to, std::move(geometry));
    }

    /// Arrays within the prototype are laid flat: Embree's instances nest but once.
    void add_instance(RTCScene to, const CompiledPrototype& source, const M44d& render_from_it) {
        for (const NestedArray& array : source.arrays)
            for (std::size_t entry = 0; entry < array.record->size(); ++entry)
                add_instance(to, array.prototype(entry),
                             array.outer_from_prototype(entry) * render_from_it);
        TreeHandle& prototype = prototypes[&source];
        if (!prototype) {
            prototype = new_tree();
            for (const Surface& part : source.surfaces) add(prototype.get(), part);
            rtcCommitScene(prototype.get());
        }
        GeometryHandle geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
        rtcSetGeometryInstancedScene(geometry.get(), prototype.get());
        float rows[12];
        for (int i = 0; i < 4; ++i)
            for (int a = 0; a < 3; ++a) rows[3 * i + a] = static_cast<float>(render_from_it[i][a]);
        rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, rows);
        attach(to, std::move(geometry));
    }
};

BareLoop::BareLoop(const Scene& scene, const std::string& isa)
    : impl_(new Impl{DeviceHandle(embree::make_device(isa, 0)), nullptr, {}}) {
    impl_->tree = impl_->new_tree();
    for (std::uint32_t slot = 0; slot < scene.slot_count(); ++slot) {
        if (!scene.live(slot)) continue;
        if (const CompiledPrototype* prototype = scene.prototype(slot))
            impl_->add_instance(impl_->tree.get(), *prototype, scene.render_from_prototype(slot));
        else
            impl_->add(impl_->tree.get(), scene.object(slot).surface);
    }
    rtcCommitScene(impl_->tree.get());
    embree::check(impl_->device.get(), "build the bare loop's tree");
}

BareLoop::~BareLoop() = default;

LoopTime BareLoop::nearest(std::span<const Ray> rays) const {
    return timed(rays, [tree = impl_->tree.get()](const Ray& ray) {
        RTCRayHit hit;
        hit.ray = bare_ray(ray);
        hit.hit.geomID = hit.hit.primID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree::Context context;
        embree::init(context);
        embree::intersect(tree, context, hit);
        return hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    });
}

LoopTime BareLoop::occlusion(std::span<const Ray> rays) const {
    return timed(rays, [tree = impl_->tree.get()](const Ray& ray) {
        RTCRay shadow = bare_ray(ray);
        embree::Context context;
        embree::init(context);
        embree::occluded(tree, context, shadow);
        return shadow.tfar < 0;
    });
}

LoopTime time_nearest(const Intersector& intersector, std::span<const Ray> rays) {
    QueryCounts counts;
    return timed(
        rays, [&](const Ray& ray) { return static_cast<bool>(intersector.nearest(ray, counts)); });
}

LoopTime time_occlusion(const Intersector& intersector, std::span<const Ray> rays) {
    QueryCounts counts;
    return timed(
        rays, [&](const Ray& ray) { return intersector.occlusion(ray, counts).blocker != none; });
}

}  // namespace irt::trace
