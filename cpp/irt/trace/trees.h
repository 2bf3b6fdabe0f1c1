// SPDX-License-Identifier: Apache-2.0
// The Embree trees of a scene and how they follow it from commit to commit. Internal to trace/.
#pragma once

#include <map>
#include <memory>
#include <type_traits>
#include <vector>

#include "irt/trace/embree.h"
#include "irt/trace/frame.h"
#include "irt/trace/intersector.h"
#include "irt/trace/judge_many.h"
#include "irt/trace/packets.h"

namespace irt::trace {

struct Release {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
    void operator()(RTCScene s) const { rtcReleaseScene(s); }
    void operator()(RTCGeometry g) const { rtcReleaseGeometry(g); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release>;
using TreeHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release>;
using GeometryHandle = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Release>;

struct Callbacks {
    struct Pair {
        RTCIntersectFunctionN intersect;
        RTCOccludedFunctionN occluded;
    };
    Pair packet, solid, instance, entries, nested;
};
const Callbacks& callbacks();

struct Group;

/// Kinds of rays, as bits: those of the camera, and all others.
enum RayKind : std::uint8_t { camera_ray = 1, other_ray = 2, any_ray = 3 };

inline RayKind met_by(const PassRole& role) { return role.camera_visible ? any_ray : other_ray; }

/// Groups by prototype of an array.
using Groups = std::vector<std::shared_ptr<const Group>>;

/// What the callbacks read of one geometry of a tree: the packets of a mesh; a quadric, or many
/// balls or segments; an instance of a group, or many.
struct Shape {
    const Frame* frame = nullptr;  ///< of the tree it is in
    std::uint32_t object = none;   ///< slot; `none` within a group, and of an array
    std::uint32_t part = 0;
    /// Those that meet it. 0: the object has changed since; this shape only awaits a rebuild.
    std::uint8_t rays = any_ray;
    bool single_sided = false;  ///< meshes

    Surface surface;  ///< all but meshes and instances: what their judge reads

    std::shared_ptr<const Triangles> triangles;  ///< meshes
    std::vector<Pair> order;
    PacketArray packets;

    std::shared_ptr<const Group> group;  ///< an instance
    M44d prototype_from_trace;

    // Entries of an array of the scene, which is asked for where they are:
    const Scene* scene = nullptr;
    const Groups* groups = nullptr;            ///< of the array as it is now
    std::vector<std::uint32_t> slots;          ///< by primitive
    const std::vector<bool>* moved = nullptr;  ///< by slot: those that left; null: none can

    // An array within a group:
    const NestedArray* nested = nullptr;
    Groups nested_groups;

    Box box;                  ///< trace space, before padding
    GeometryHandle geometry;  ///< null where there is nothing to hit
    /// Primitives that Embree is told of.
    [[nodiscard]] std::size_t weight() const {
        return triangles ? packets.size()
               : nested  ? nested->record->size()
               : scene   ? slots.size()
               : group   ? 1
                         : primitive_count(surface);
    }
    [[nodiscard]] const Group& group_of_slot(std::uint32_t slot) const {
        return *(*groups)[scene->object(slot).array->prototype(scene->entry(slot))];
    }
    /// The box of one of Embree's primitives, trace space, before padding; may be empty.
    [[nodiscard]] Box box_of(std::uint32_t primitive) const;
};

/// A prototype's own tree.
struct Group {
    std::shared_ptr<const CompiledPrototype> prototype;
    Frame frame;
    std::vector<std::unique_ptr<Shape>> shapes;
    TreeHandle tree;
};

class Trees {
  public:
    Trees(const std::string& isa, int threads, TreeOptions options);

    void commit(const Scene& scene, const std::vector<std::uint32_t>& changed);
    void commit(const Scene& scene, const std::vector<std::uint32_t>& changed,
                const TreesState& state);
    [[nodiscard]] TreesState state() const;
    void follow(const AppliedChanges& applied);

    [[nodiscard]] const Scene* scene() const { return scene_; }
    [[nodiscard]] const Frame& frame() const { return frame_; }
    [[nodiscard]] RTCScene still() const { return still_.get(); }    ///< null: empty
    [[nodiscard]] RTCScene moving() const { return moving_.get(); }  ///< null: empty
    [[nodiscard]] bool moves(std::uint32_t slot) const { return moves_[slot]; }
    [[nodiscard]] std::uint32_t epoch() const { return epoch_; }
    [[nodiscard]] Box box(std::uint32_t slot) const;
    [[nodiscard]] Box box(const CompiledPrototype& prototype,
                          const M44d& render_from_prototype) const;

  private:
    /// An array: one geometry of the still tree for all entries that stay, and one of the moving
    /// tree for the others.
    struct Entries {
        Groups groups;
        RayKind rays = any_ray;             ///< those that meet the array
        std::unique_ptr<Shape> still;       ///< those there were when the still tree was built
        std::size_t retired = 0;            ///< of `still`: have changed since
        std::vector<std::uint32_t> movers;  ///< slots of those that have changed since, and live
        std::unique_ptr<Shape> moving;      ///< the movers
        Box box;                            ///< of all there were since then
    };
    /// What the trees hold of an object of the scene.
    struct Object {
        std::unique_ptr<Shape> shape;      ///< null: nothing to trace, or an array
        std::unique_ptr<Entries> entries;  ///< null: no array
    };

    std::unique_ptr<Shape> make_shape(const Surface& surface, const Shape* previous);
    std::unique_ptr<Shape> make_object(const ObjectSlot& object, const Shape* previous);
    std::unique_ptr<Shape> make_nested(const NestedArray& array);
    std::unique_ptr<Shape> make_entries(const Entries& entries, std::vector<std::uint32_t> slots);
    std::shared_ptr<const Group> group_of(const std::shared_ptr<const CompiledPrototype>& key);
    Groups groups_of(const ObjectSlot& array);
    void attach_geometry(Shape& shape, const Frame& frame);
    TreeHandle build(const std::vector<const Shape*>& shapes);
    std::vector<bool> take(const Scene& scene, const std::vector<std::uint32_t>& changed);
    void take_object(std::uint32_t slot);
    void take_entries(std::uint32_t index, const std::vector<std::uint32_t>& changed,
                      const std::vector<bool>& hot);
    [[nodiscard]] bool fold_is_due(const std::vector<bool>& hot) const;
    void build_still(const std::vector<bool>& hot);
    void build_moving();
    bool fit_frame();
    [[nodiscard]] bool split_off(std::uint32_t slot) const;

    DeviceHandle device_;
    TreeOptions options_;
    const Scene* scene_ = nullptr;
    Frame frame_;
    std::vector<Object> objects_;                  ///< by index in the scene
    std::vector<bool> moves_;                      ///< by slot: in the moving tree
    std::size_t still_slots_ = 0;                  ///< slots when the still tree was built
    std::vector<std::unique_ptr<Shape>> retired_;  ///< inactive shapes the still tree refers to
    std::map<const CompiledPrototype*, std::weak_ptr<const Group>> groups_;
    TreeHandle still_, moving_;
    std::uint32_t epoch_ = 0;  ///< counts the builds of the still tree
};

}  // namespace irt::trace
