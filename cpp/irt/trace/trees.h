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
    Pair packet, solid, instance;
};
const Callbacks& callbacks();

struct Group;

/// What the callbacks read of one geometry of a tree: the packets of a mesh; a quadric, or many
/// balls or segments; or an instance of a group.
struct Shape {
    const Frame* frame = nullptr;  ///< of the tree it is in
    std::uint32_t object = none;   ///< slot; `none` within a group
    std::uint32_t part = 0;
    bool active = true;  ///< false: the object has changed since; this shape only awaits a rebuild
    bool single_sided = false;  ///< meshes

    Surface surface;  ///< all but meshes and instances: what their judge reads

    std::shared_ptr<const Triangles> triangles;  ///< meshes
    std::vector<Pair> order;
    PacketArray packets;

    std::shared_ptr<const Group> group;  ///< instances
    M44d prototype_from_trace;

    Box box;                  ///< trace space, before padding
    GeometryHandle geometry;  ///< null where there is nothing to hit
    /// Primitives that Embree is told of.
    [[nodiscard]] std::size_t weight() const {
        return triangles ? packets.size() : primitive_count(surface);
    }
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
    void release_meshes(const std::vector<std::uint32_t>& rebound);

    [[nodiscard]] const Scene* scene() const { return scene_; }
    [[nodiscard]] const Frame& frame() const { return frame_; }
    [[nodiscard]] RTCScene still() const { return still_.get(); }    ///< null: empty
    [[nodiscard]] RTCScene moving() const { return moving_.get(); }  ///< null: empty
    [[nodiscard]] bool moves(std::uint32_t slot) const { return objects_[slot].moves; }
    [[nodiscard]] std::uint32_t epoch() const { return epoch_; }
    [[nodiscard]] Box box(std::uint32_t slot) const;

  private:
    struct Object {
        std::unique_ptr<Shape> shape;
        bool moves = false;  ///< in the moving tree
    };

    std::unique_ptr<Shape> make_shape(const Surface& surface, const Shape* previous);
    std::unique_ptr<Shape> make_object(const Scene& scene, std::uint32_t slot,
                                       const Shape* previous);
    std::shared_ptr<const Group> group_of(const std::shared_ptr<const CompiledPrototype>& key);
    void attach_geometry(Shape& shape, const Frame& frame);
    TreeHandle build(const std::vector<const Shape*>& shapes);
    bool fit_frame();
    [[nodiscard]] bool split_off(std::uint32_t slot) const;

    DeviceHandle device_;
    TreeOptions options_;
    const Scene* scene_ = nullptr;
    Frame frame_;
    std::vector<Object> objects_;                  ///< by slot
    std::vector<std::unique_ptr<Shape>> retired_;  ///< inactive shapes the still tree refers to
    std::map<const CompiledPrototype*, std::weak_ptr<const Group>> groups_;
    TreeHandle still_, moving_;
    std::uint32_t epoch_ = 0;  ///< counts the builds of the still tree
};

}  // namespace irt::trace
