// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/trees.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "irt/scene/equality.h"

namespace irt::trace {
namespace {

/// Room left in the frame when it is fitted, so that small movements do not outgrow it.
constexpr double frame_room = 1.125;

/// The still tree is rebuilt when what it holds in vain, and what the moving tree holds though it
/// moves no longer, come to this share of it. Counted in packets, solids and instances.
constexpr double fold_share = 0.25;

float down(double x) {
    const auto f = static_cast<float>(x);
    return std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float up(double x) {
    const auto f = static_cast<float>(x);
    return std::nextafter(f, std::numeric_limits<float>::infinity());
}

void bounds_callback(const RTCBoundsFunctionArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    const Box box = shape.triangles ? bounds(shape.packets[arguments->primID])
                    : shape.group   ? shape.box
                                    : primitive_box(shape.surface, arguments->primID);
    const Frame& frame = *shape.frame;
    const double pad = frame.pad();
    RTCBounds& out = *arguments->bounds_o;
    if (box.empty()) {  // what Embree leaves out
        out.lower_x = out.lower_y = out.lower_z = std::numeric_limits<float>::infinity();
        out.upper_x = out.upper_y = out.upper_z = -std::numeric_limits<float>::infinity();
        return;
    }
    out.lower_x = down(box.lower.x - frame.centre.x - pad);
    out.lower_y = down(box.lower.y - frame.centre.y - pad);
    out.lower_z = down(box.lower.z - frame.centre.z - pad);
    out.upper_x = up(box.upper.x - frame.centre.x + pad);
    out.upper_y = up(box.upper.y - frame.centre.y + pad);
    out.upper_z = up(box.upper.z - frame.centre.z + pad);
}

/// The box of `box` under the affine `a_from_b`.
Box transformed(const Box& box, const M44d& a_from_b) {
    Box out;
    for (int corner = 0; corner < 8; ++corner)
        out.extend(transform_point(a_from_b, {(corner & 1 ? box.upper : box.lower).x,
                                              (corner & 2 ? box.upper : box.lower).y,
                                              (corner & 4 ? box.upper : box.lower).z}));
    return out;
}

double reach(const Box& box, const V3d& centre) {
    double most = 0;
    for (int a = 0; a < 3; ++a)
        most = std::max(
            {most, std::fabs(box.lower[a] - centre[a]), std::fabs(box.upper[a] - centre[a])});
    return most;
}

Box padded(Box box, double pad) {
    for (int a = 0; a < 3; ++a) {
        box.lower[a] -= pad;
        box.upper[a] += pad;
    }
    return box;
}

}  // namespace

namespace embree {

RTCDevice make_device(const std::string& isa, int threads) {
    static const char* const names[] = {"sse2", "sse4.2", "avx", "avx2", "avx512"};
    if (std::find(std::begin(names), std::end(names), isa) == std::end(names))
        throw std::invalid_argument("instruction set '" + isa +
                                    "' is none of sse2, sse4.2, avx, avx2, avx512");
    const std::string configuration =
        "isa=" + isa + ",threads=" + std::to_string(std::max(threads, 0));
    RTCDevice device = rtcNewDevice(configuration.c_str());
    if (device) return device;
    if (rtcGetDeviceError(nullptr) == RTC_ERROR_UNSUPPORTED_CPU)
        throw std::invalid_argument("this processor lacks the instruction set " + isa +
                                    "; the best it has is " + best_isa());
    throw std::runtime_error("Embree failed to make a device");
}

}  // namespace embree

std::string embree_version() { return RTC_VERSION_STRING; }

std::string best_isa() {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl"))
        return "avx512";
    if (__builtin_cpu_supports("avx2")) return "avx2";
    if (__builtin_cpu_supports("avx")) return "avx";
    return __builtin_cpu_supports("sse4.2") ? "sse4.2" : "sse2";
}

Trees::Trees(const std::string& isa, int threads, TreeOptions options)
    : device_(embree::make_device(isa, threads)), options_(options) {}

bool Trees::split_off(std::uint32_t slot) const {
    if (options_.split_seed == 0) return false;
    std::uint32_t h = (slot + 1) * 0x9e3779b1u ^ options_.split_seed;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return ((h ^ (h >> 16)) & 1) != 0;
}

std::unique_ptr<Shape> Trees::make_shape(const Surface& surface, const Shape* previous) {
    auto shape = std::make_unique<Shape>();
    shape->triangles = surface.triangles;
    if (!surface.triangles) {
        shape->surface = surface;
        for (std::uint32_t k = 0; k < primitive_count(surface); ++k)
            if (const Box box = primitive_box(surface, k); !box.empty()) shape->box.extend(box);
        return shape;
    }
    const Triangles& triangles = *surface.triangles;
    shape->single_sided = triangles.mesh->single_sided;
    // A mesh that merely moved keeps its clusters: neighbours stay neighbours.
    const bool moved = previous && previous->triangles &&
                       (previous->triangles->mesh == triangles.mesh ||
                        same_hits(*previous->triangles->mesh, *triangles.mesh)) &&
                       previous->triangles->triangles == triangles.triangles;
    shape->order = moved ? previous->order : cluster(triangles);
    shape->packets = make_packets(triangles, shape->order);
    for (const TrianglePacket& packet : shape->packets) shape->box.extend(bounds(packet));
    return shape;
}

void Trees::attach_geometry(Shape& shape, const Frame& frame) {
    shape.frame = &frame;
    if (shape.box.empty() || shape.weight() == 0) return;
    const Callbacks& all = callbacks();
    const Callbacks::Pair& pair = shape.group       ? all.instance
                                  : shape.triangles ? all.packet
                                                    : all.solid;
    shape.geometry.reset(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
    RTCGeometry geometry = shape.geometry.get();
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(shape.weight()));
    rtcSetGeometryUserData(geometry, &shape);
    rtcSetGeometryBoundsFunction(geometry, bounds_callback, nullptr);
    rtcSetGeometryIntersectFunction(geometry, pair.intersect);
    rtcSetGeometryOccludedFunction(geometry, pair.occluded);
    rtcCommitGeometry(geometry);
    embree::check(device_.get(), "make a geometry");
}

TreeHandle Trees::build(const std::vector<const Shape*>& shapes) {
    TreeHandle tree;
    for (const Shape* shape : shapes) {
        if (!shape->geometry) continue;
        if (!tree) {
            tree.reset(rtcNewScene(device_.get()));
            rtcSetSceneBuildQuality(tree.get(), options_.low_quality ? RTC_BUILD_QUALITY_LOW
                                                                     : RTC_BUILD_QUALITY_MEDIUM);
        }
        rtcAttachGeometry(tree.get(), shape->geometry.get());
    }
    if (tree) rtcCommitScene(tree.get());
    embree::check(device_.get(), "build a tree");
    return tree;
}

std::shared_ptr<const Group> Trees::group_of(const std::shared_ptr<const CompiledPrototype>& key) {
    if (auto known = groups_[key.get()].lock()) return known;
    auto group = std::make_shared<Group>();
    group->prototype = key;
    std::vector<const Shape*> shapes;
    for (std::uint32_t part = 0; part < key->surfaces.size(); ++part) {
        group->shapes.push_back(make_shape(key->surfaces[part], nullptr));
        group->shapes.back()->part = part;
        if (!group->shapes.back()->box.empty()) group->frame.box.extend(group->shapes.back()->box);
    }
    Frame& frame = group->frame;
    if (!frame.box.empty()) {
        frame.centre = frame.box.lower * 0.5 + frame.box.upper * 0.5;
        frame.half = reach(frame.box, frame.centre) * frame_room;
        frame.box = padded(frame.box, frame.pad());
        for (auto& shape : group->shapes) {
            attach_geometry(*shape, frame);
            shapes.push_back(shape.get());
        }
        group->tree = build(shapes);
    }
    groups_[key.get()] = group;
    return group;
}

std::unique_ptr<Shape> Trees::make_object(const Scene& scene, std::uint32_t slot,
                                          const Shape* previous) {
    const ObjectSlot& object = scene.objects()[slot];
    std::unique_ptr<Shape> shape;
    if (object.prototype) {
        shape = std::make_unique<Shape>();
        shape->group = group_of(object.prototype);
        shape->prototype_from_trace = object.prototype_from_render;
        if (shape->group->tree)
            shape->box = transformed(shape->group->frame.box, object.render_from_prototype);
    } else {
        shape = make_shape(object.surface, previous);
    }
    shape->object = slot;
    return shape;
}

/// Grows the frame to hold every object; true if it had to change, and with it every pad.
bool Trees::fit_frame() {
    Box box;
    for (const Object& object : objects_)
        if (object.shape && !object.shape->box.empty()) box.extend(object.shape->box);
    if (box.empty()) return false;
    const double most = reach(box, frame_.centre);
    const bool fits = most <= frame_.half && frame_.half <= most * 4;
    if (!fits) frame_.half = most * frame_room;
    frame_.box = padded(box, frame_.pad());
    return !fits;
}

Box Trees::box(std::uint32_t slot) const {
    if (slot >= objects_.size() || !objects_[slot].shape || objects_[slot].shape->box.empty())
        return {};
    return padded(objects_[slot].shape->box, frame_.pad());
}

/// Lets go of the meshes that `rebound` objects, met as before, no longer shade by.
void Trees::release_meshes(const std::vector<std::uint32_t>& rebound) {
    for (const std::uint32_t slot : rebound)
        if (Shape* shape = objects_[slot].shape.get(); shape && shape->triangles)
            shape->triangles = scene_->objects()[slot].surface.triangles;
}

void Trees::commit(const Scene& scene, const std::vector<std::uint32_t>& changed) {
    const bool first = scene_ == nullptr;
    scene_ = &scene;
    moving_.reset();  // first: it refers to shapes that go
    objects_.resize(scene.objects().size());
    std::vector<bool> hot(objects_.size(), false);
    for (const std::uint32_t slot : changed) {
        if (hot[slot]) continue;
        hot[slot] = true;
        Object& object = objects_[slot];
        std::unique_ptr<Shape> previous = std::move(object.shape);
        if (scene.objects()[slot].live) object.shape = make_object(scene, slot, previous.get());
        if (previous && !object.moves) {
            previous->active = false;
            retired_.push_back(std::move(previous));
        }
        object.moves = true;
        if (object.shape) attach_geometry(*object.shape, frame_);
    }
    std::erase_if(groups_, [](const auto& entry) { return entry.second.expired(); });

    std::size_t still = 0, in_vain = 0;
    for (const auto& shape : retired_) in_vain += shape->weight();
    for (std::uint32_t slot = 0; slot < objects_.size(); ++slot) {
        const Object& object = objects_[slot];
        if (!object.shape) continue;
        if (!object.moves)
            still += object.shape->weight();
        else if (!hot[slot] && !split_off(slot))
            in_vain += object.shape->weight();
    }
    const bool refit = fit_frame();
    if (first || refit ||
        static_cast<double>(in_vain) > fold_share * static_cast<double>(still + in_vain)) {
        still_.reset();
        retired_.clear();
        std::vector<const Shape*> shapes;
        for (std::uint32_t slot = 0; slot < objects_.size(); ++slot) {
            Object& object = objects_[slot];
            object.moves = split_off(slot) || (!first && hot[slot]);
            if (object.shape && !object.moves) shapes.push_back(object.shape.get());
        }
        still_ = build(shapes);
        ++epoch_;
    }
    std::vector<const Shape*> shapes;
    for (const Object& object : objects_)
        if (object.shape && object.moves) shapes.push_back(object.shape.get());
    moving_ = build(shapes);
}

}  // namespace irt::trace
