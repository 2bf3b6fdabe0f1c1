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
    const Frame& frame = *shape.frame;
    const Box box = shape.box_of(arguments->primID);
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

Box Shape::box_of(std::uint32_t primitive) const {
    if (triangles) return bounds(packets[primitive]);
    if (nested) {
        const Group& within = *nested_groups[nested->record->prototype(primitive)];
        return within.tree ? transformed(within.frame.box, nested->outer_from_prototype(primitive))
                           : Box();
    }
    if (group) return box;
    if (!scene) return primitive_box(surface, primitive);
    const std::uint32_t slot = slots[primitive];
    const Group& within = group_of_slot(slot);
    return within.tree ? transformed(within.frame.box, scene->render_from_prototype(slot)) : Box();
}

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
                                  : shape.nested    ? all.nested
                                  : shape.scene     ? all.entries
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
        group->shapes.back()->rays = met_by(key->surfaces[part].role);
        if (!group->shapes.back()->box.empty()) group->frame.box.extend(group->shapes.back()->box);
    }
    for (const NestedArray& array : key->arrays) {
        group->shapes.push_back(make_nested(array));
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

std::unique_ptr<Shape> Trees::make_nested(const NestedArray& array) {
    auto shape = std::make_unique<Shape>();
    shape->part = array.first_part;
    shape->nested = &array;
    shape->rays = met_by(array.role);
    for (const auto& prototype : array.prototypes)
        shape->nested_groups.push_back(group_of(prototype));
    for (std::uint32_t entry = 0; entry < array.record->size(); ++entry)
        if (const Box box = shape->box_of(entry); !box.empty()) shape->box.extend(box);
    return shape;
}

std::unique_ptr<Shape> Trees::make_object(const ObjectSlot& object, const Shape* previous) {
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
    shape->object = object.slot;
    shape->rays = met_by(object.record.role);
    return shape;
}

/// Of `slots` those where there is something to hit.
std::unique_ptr<Shape> Trees::make_entries(const Entries& entries,
                                           std::vector<std::uint32_t> slots) {
    auto shape = std::make_unique<Shape>();
    shape->scene = scene_;
    shape->rays = entries.rays;
    shape->groups = &entries.groups;
    std::erase_if(slots, [&](std::uint32_t slot) { return !shape->group_of_slot(slot).tree; });
    shape->slots = std::move(slots);
    for (std::uint32_t i = 0; i < shape->slots.size(); ++i) shape->box.extend(shape->box_of(i));
    return shape;
}

/// Grows the frame to hold every object; true if it had to change, and with it every pad.
bool Trees::fit_frame() {
    Box box;
    for (const Object& object : objects_) {
        if (object.shape && !object.shape->box.empty()) box.extend(object.shape->box);
        if (object.entries && !object.entries->box.empty()) box.extend(object.entries->box);
    }
    if (box.empty()) return false;
    const double most = reach(box, frame_.centre);
    const bool fits = most <= frame_.half && frame_.half <= most * 4;
    if (!fits) frame_.half = most * frame_room;
    frame_.box = padded(box, frame_.pad());
    return !fits;
}

Box Trees::box(std::uint32_t slot) const {
    if (slot >= moves_.size()) return {};
    const std::uint32_t index = scene_->object_index(slot);
    if (scene_->all_objects()[index].array)
        return scene_->live(slot)
                   ? box(*scene_->prototype(slot), scene_->render_from_prototype(slot))
                   : Box();
    const Object& object = objects_[index];
    if (!object.shape || object.shape->box.empty()) return {};
    return padded(object.shape->box, frame_.pad());
}

Box Trees::box(const CompiledPrototype& prototype, const M44d& render_from_prototype) const {
    const auto found = groups_.find(&prototype);
    const auto group = found == groups_.end() ? nullptr : found->second.lock();
    if (!group || !group->tree) return {};
    return padded(transformed(group->frame.box, render_from_prototype), frame_.pad());
}

/// Takes up an object that changed and is no array.
void Trees::take_object(std::uint32_t slot) {
    const ObjectSlot& record = scene_->object(slot);
    Object& object = objects_[scene_->object_index(slot)];
    std::unique_ptr<Shape> previous = std::move(object.shape);
    if (record.live) object.shape = make_object(record, previous.get());
    if (previous && !moves_[slot]) {
        previous->rays = 0;
        retired_.push_back(std::move(previous));
    }
    moves_[slot] = true;
    if (object.shape) attach_geometry(*object.shape, frame_);
}

Groups Trees::groups_of(const ObjectSlot& array) {
    Groups groups;
    for (const auto& prototype : array.prototypes) groups.push_back(group_of(prototype));
    return groups;
}

/// Takes up an array, of which the entries `changed` did.
void Trees::take_entries(std::uint32_t index, const std::vector<std::uint32_t>& changed,
                         const std::vector<bool>& hot) {
    const ObjectSlot& array = scene_->all_objects()[index];
    if (!objects_[index].entries) objects_[index].entries = std::make_unique<Entries>();
    Entries& entries = *objects_[index].entries;
    entries.groups = groups_of(array);
    std::erase_if(entries.movers, [&](std::uint32_t slot) { return hot[slot]; });
    for (const std::uint32_t slot : changed) {
        if (!moves_[slot] && slot < still_slots_) ++entries.retired;
        moves_[slot] = true;
        if (scene_->live(slot)) entries.movers.push_back(slot);
    }
    entries.rays = met_by(array.record.role);
    entries.moving = make_entries(entries, entries.movers);
    if (!entries.moving->box.empty()) entries.box.extend(entries.moving->box);
}

/// Whether what the still tree holds in vain, and what the moving tree holds though it has stood
/// since the last commit, have come to too large a share. `hot`: by slot, what has not.
bool Trees::fold_is_due(const std::vector<bool>& hot) const {
    std::size_t still = 0, in_vain = 0;
    for (const auto& shape : retired_) in_vain += shape->weight();
    for (const Object& object : objects_) {
        if (const Shape* shape = object.shape.get()) {
            if (!moves_[shape->object])
                still += shape->weight();
            else if (!hot[shape->object] && !split_off(shape->object))
                in_vain += shape->weight();
        }
        if (!object.entries) continue;
        const std::size_t built = object.entries->still ? object.entries->still->slots.size() : 0;
        const std::size_t retired = std::min(built, object.entries->retired);
        still += built - retired;
        in_vain += retired;
        for (const std::uint32_t slot : object.entries->movers)
            in_vain += hot[slot] || split_off(slot) ? 0 : 1;
    }
    return static_cast<double>(in_vain) > fold_share * static_cast<double>(still + in_vain);
}

/// Builds the still tree of all but `hot`, which goes to the moving one.
void Trees::build_still(const std::vector<bool>& hot) {
    still_.reset();
    retired_.clear();
    const auto moves = [&](std::uint32_t slot) { return split_off(slot) || hot[slot]; };
    std::vector<const Shape*> shapes;
    for (std::uint32_t index = 0; index < objects_.size(); ++index) {
        Object& object = objects_[index];
        const ObjectSlot& record = scene_->all_objects()[index];
        if (!record.array) moves_[record.slot] = moves(record.slot);
        if (object.shape && !moves_[record.slot]) shapes.push_back(object.shape.get());
        if (!object.entries) continue;
        Entries& entries = *object.entries;
        std::vector<std::uint32_t> staying;
        entries.movers.clear();
        for (const std::uint32_t slot : scene_->entry_slots(record)) {
            moves_[slot] = moves(slot);
            (moves_[slot] ? entries.movers : staying).push_back(slot);
        }
        entries.still = make_entries(entries, std::move(staying));
        entries.still->moved = &moves_;
        entries.retired = 0;
        attach_geometry(*entries.still, frame_);
        shapes.push_back(entries.still.get());
        entries.moving = make_entries(entries, entries.movers);
        entries.box = entries.still->box;
        if (!entries.moving->box.empty()) entries.box.extend(entries.moving->box);
    }
    still_ = build(shapes);
    still_slots_ = moves_.size();
    ++epoch_;
}

void Trees::build_moving() {
    std::vector<const Shape*> shapes;
    for (const Object& object : objects_) {
        if (object.shape && moves_[object.shape->object]) shapes.push_back(object.shape.get());
        if (!object.entries || object.entries->movers.empty()) continue;
        Shape& moving = *object.entries->moving;
        if (!moving.geometry) attach_geometry(moving, frame_);
        shapes.push_back(&moving);
    }
    moving_ = build(shapes);
}

/// Lets go of the meshes that rebound objects, met as before, no longer shade by; and finds the
/// prototypes of arrays where they stand now.
void Trees::follow(const AppliedChanges& applied) {
    for (const std::uint32_t index : applied.renumbered) {
        if (index >= objects_.size()) continue;  // no entry of it was committed yet
        if (Entries* entries = objects_[index].entries.get())
            entries->groups = groups_of(scene_->all_objects()[index]);
    }
    for (const std::uint32_t slot : applied.rebound)
        if (Shape* shape = objects_[scene_->object_index(slot)].shape.get();
            shape && shape->triangles)
            shape->triangles = scene_->object(slot).surface.triangles;
}

/// Takes up what changed; the result says by slot what that is. The trees are to be built next.
std::vector<bool> Trees::take(const Scene& scene, const std::vector<std::uint32_t>& changed) {
    scene_ = &scene;
    moving_.reset();  // first: it refers to shapes that go
    objects_.resize(scene.all_objects().size());
    moves_.resize(scene.slot_count());
    std::vector<bool> hot(moves_.size(), false);
    std::map<std::uint32_t, std::vector<std::uint32_t>> arrays;
    for (const std::uint32_t slot : changed) {
        if (hot[slot]) continue;
        hot[slot] = true;
        if (scene.object(slot).array)
            arrays[scene.object_index(slot)].push_back(slot);
        else
            take_object(slot);
    }
    for (const auto& [index, slots] : arrays) take_entries(index, slots, hot);
    std::erase_if(groups_, [](const auto& entry) { return entry.second.expired(); });
    return hot;
}

void Trees::commit(const Scene& scene, const std::vector<std::uint32_t>& changed) {
    const bool first = scene_ == nullptr;
    const std::vector<bool> hot = take(scene, changed);
    const bool refit = fit_frame();
    if (first)
        build_still(std::vector<bool>(hot.size(), false));
    else if (refit || fold_is_due(hot))
        build_still(hot);
    build_moving();
}

TreesState Trees::state() const {
    return {epoch_, frame_.centre, frame_.half, {moves_.begin(), moves_.end()}};
}

void Trees::commit(const Scene& scene, const std::vector<std::uint32_t>& changed,
                   const TreesState& state) {
    if (state.moves.size() != scene.slot_count())
        throw std::runtime_error("trees: of a scene with other slots");
    frame_.centre = state.centre;
    frame_.half = state.half;
    take(scene, changed);
    fit_frame();
    const std::vector<bool> moves(state.moves.begin(), state.moves.end());
    build_still(moves);
    moves_ = moves;  // of names that are gone, too
    epoch_ = state.epoch;
    build_moving();
}

}  // namespace irt::trace
