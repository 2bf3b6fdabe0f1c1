// SPDX-License-Identifier: Apache-2.0
// A scene: the records in force, and what tracing and shading read of them. A scene knows no camera
// and no film; several views may show it.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "irt/scene/change_set.h"
#include "irt/scene/placement.h"
#include "irt/scene/surface.h"
#include "irt/trace/box.h"
#include "irt/trace/ray.h"
#include "irt/trace/shadow_rule.h"

namespace irt {

/// What there is, or was, under a path: an object, or an array of them.
struct ObjectSlot {
    bool live = false;
    std::string path;
    std::uint32_t rank = 0;  ///< order of `path` among all paths: ties go to the lower rank
    std::uint32_t id = 0;    ///< MurmurHash3 (x86, 32 bit) of `path`: what id AOVs show
    std::uint32_t slot = 0;  ///< in the scene; unless an array, whose entries have slots
    Object record;
    Surface surface;                                     ///< unless instances
    std::shared_ptr<const CompiledPrototype> prototype;  ///< an instance's shapes, else null
    M44d render_from_prototype, prototype_from_render;   ///< an instance

    std::shared_ptr<const InstanceArray> array;                        ///< null: no array
    std::vector<std::shared_ptr<const CompiledPrototype>> prototypes;  ///< the array's, as there
    M44d render_from_array;

    /// Unless an array.
    [[nodiscard]] const Surface& part(std::uint32_t number) const {
        return prototype ? prototype->part(number) : surface;
    }
    [[nodiscard]] const CompiledPrototype& prototype_of(std::size_t entry) const {
        return *prototypes[array->prototype(entry)];
    }
    [[nodiscard]] M44d render_from_entry(std::size_t entry) const {
        return placed(array->array_from_prototype[entry], render_from_array);
    }
};

/// The slots of the materials that `object` shows; an array's entries together.
[[nodiscard]] std::vector<std::uint32_t> materials_of(const ObjectSlot& object);

/// A material's slot belongs to its name for the life of the scene.
struct MaterialSlot {
    bool live = false;
    std::string name;
    Material record;
    bool tint_varies = false;  ///< from point to point, by `tint_nodes` of its graph
    std::vector<std::int32_t> tint_nodes;
    bool tint_reads_place = false;     ///< some of them do
    trace::OpticalDepth shadow_depth;  ///< else: tint of a shadow ray crossing one primitive of it
    std::uint32_t id = 0;              ///< MurmurHash3 (x86, 32 bit) of `name`
};

struct LightSlot {
    std::string path;
    std::uint32_t id = 0;
    Light record;
    V3d position_render;  ///< render space, double
    /// By index into all_objects(): those it does not light; may end before them.
    std::vector<bool> unlit;
    bool shaped = false;  ///< it does not send the same in all directions
    std::optional<trace::ShadowRule> shadow_rule;

    [[nodiscard]] bool lights(std::uint32_t object) const {
        return object >= unlit.size() || !unlit[object];
    }
    /// How its shadows differ from those that all cast alike; null: they do not.
    [[nodiscard]] const trace::ShadowRule* rule() const {
        return shadow_rule ? &*shadow_rule : nullptr;
    }
};

/// Entries of an array as they were.
struct FormerEntries {
    ObjectSlot array;
    std::vector<std::uint32_t> entries;
};

/// MurmurHash3 (x86, 32 bit) of a name.
[[nodiscard]] std::uint32_t path_hash(const std::string& path);

/// The compiled form of a prototype; `path` begins what is said of it where it cannot be rendered.
using PrototypeCompiler = std::function<std::shared_ptr<const CompiledPrototype>(
    const std::shared_ptr<const Prototype>& prototype, const std::string& path)>;

/// What `Scene::apply` found to differ, record by record and by value.
struct AppliedChanges {
    std::vector<std::uint32_t> geometry;  ///< object slots added, removed, moved or reshaped
    std::vector<ObjectSlot> previous;     ///< of `geometry`: as they were, dead ones left out
    std::vector<FormerEntries> former;    ///< likewise, the entries of arrays
    /// Into all_objects(): arrays whose prototypes stand otherwise, whatever that changes.
    std::vector<std::uint32_t> renumbered;
    std::vector<std::uint32_t> rebound;  ///< object slots that shade otherwise where hit as before
    std::vector<std::uint32_t> unbound;  ///< of `rebound`: the material slots they had
    std::vector<std::uint32_t> materials;  ///< material slots whose values changed
    std::vector<std::string> lights;       ///< lights added, removed or changed, by path
    std::vector<std::uint32_t> tints;     ///< of `materials`: those that now tint shadows otherwise
    std::vector<std::uint32_t> retinted;  ///< of `rebound`: objects that now tint shadows otherwise
    [[nodiscard]] bool empty() const {
        return geometry.empty() && rebound.empty() && materials.empty() && lights.empty();
    }
};

/// Who has which number: what every name a scene has known, dead ones too, keeps for its life.
struct SceneNames {
    /// Keys of an array's entries, `count` of both in a row.
    struct Keys {
        std::int64_t key;
        std::uint32_t object, slot, count, unused = 0;
    };
    std::vector<char> objects;         ///< paths by index, each ended by a zero
    std::vector<std::uint8_t> arrays;  ///< by index: whether it is an array
    std::vector<std::uint32_t> slots;  ///< by slot: the index
    std::vector<Keys> keys;
    std::vector<char> materials;  ///< names by slot, each ended by a zero

    bool operator==(const SceneNames& other) const;

    /// For checkpoints (checkpoint/arrays.h).
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self) {
        auto& [of_objects, is_array, of_slots, of_keys, of_materials] = self;
        to.array(name + "objects", of_objects);
        to.array(name + "arrays", is_array);
        to.array(name + "slots", of_slots);
        to.array(name + "keys", of_keys);
        to.array(name + "materials", of_materials);
    }
};

class Scene {
  public:
    /// `render_origin`: world position that becomes the origin of render space (DESIGN 5).
    explicit Scene(const V3d& render_origin);

    /// Applies `changes`; a record equal to the one in force is no change.
    /// Throws std::invalid_argument, naming the path, on records that cannot be rendered
    /// (singular or non-finite transforms, indices out of range, an unknown material); nothing is
    /// then applied.
    AppliedChanges apply(const ChangeSet& changes);

    [[nodiscard]] const V3d& render_origin() const { return render_origin_; }

    /// Slots are the numbers of objects, an array's entries among them. A slot belongs to its name
    /// (a path; a path and a key) for the life of the scene, so that no history can mistake one
    /// object for another.
    [[nodiscard]] std::uint32_t slot_count() const {
        return static_cast<std::uint32_t>(slots_.size());
    }
    /// What the slot is of: an object, or the array that it is an entry of.
    [[nodiscard]] const ObjectSlot& object(std::uint32_t slot) const {
        return objects_[slots_[slot].object];
    }
    /// Index into all_objects().
    [[nodiscard]] std::uint32_t object_index(std::uint32_t slot) const {
        return slots_[slot].object;
    }
    /// Place in the array's record, of a live slot.
    [[nodiscard]] std::uint32_t entry(std::uint32_t slot) const { return slots_[slot].entry; }
    /// Whether there is an object of that name now.
    [[nodiscard]] bool live(std::uint32_t slot) const {
        return slots_[slot].entry != trace::none && object(slot).live;
    }
    /// What there is or was under every path, arrays as one.
    [[nodiscard]] const std::vector<ObjectSlot>& all_objects() const { return objects_; }
    /// The slots of the entries of an array, in their order.
    [[nodiscard]] std::vector<std::uint32_t> entry_slots(const ObjectSlot& array) const;

    // Of live slots:
    [[nodiscard]] const Surface& surface(std::uint32_t slot, std::uint32_t part) const {
        const ObjectSlot& o = object(slot);
        return o.array ? o.prototype_of(entry(slot)).part(part) : o.part(part);
    }
    /// Whether the render pass holds out a part, or the whole object.
    [[nodiscard]] bool matte(std::uint32_t slot, std::uint32_t part) const;
    /// Null: no instance.
    [[nodiscard]] const CompiledPrototype* prototype(std::uint32_t slot) const {
        const ObjectSlot& o = object(slot);
        return o.array ? &o.prototype_of(entry(slot)) : o.prototype.get();
    }
    /// Of instances.
    [[nodiscard]] M44d render_from_prototype(std::uint32_t slot) const {
        const ObjectSlot& o = object(slot);
        return o.array ? o.render_from_entry(entry(slot)) : o.render_from_prototype;
    }
    [[nodiscard]] M44d prototype_from_render(std::uint32_t slot) const {
        const ObjectSlot& o = object(slot);
        return o.array ? inverse_of(o.render_from_entry(entry(slot))) : o.prototype_from_render;
    }
    /// From the space that a part's Surface is in; the identity where that is render space.
    [[nodiscard]] M44d render_from_trace(std::uint32_t slot, std::uint32_t part) const;
    /// Whether ties go to the first of two slots: by path, then by key.
    [[nodiscard]] bool before(std::uint32_t first, std::uint32_t second) const {
        const std::uint32_t rank = object(first).rank, other = object(second).rank;
        return rank != other ? rank < other : entry(first) < entry(second);
    }
    /// The path; of an entry, with its key: /Trees[5].
    [[nodiscard]] std::string name(std::uint32_t slot) const;
    /// MurmurHash3 (x86, 32 bit) of the name: what id AOVs show.
    [[nodiscard]] std::uint32_t id(std::uint32_t slot) const;
    /// Of an entry its key, of an object that is none nothing.
    [[nodiscard]] std::optional<std::int64_t> key(std::uint32_t slot) const {
        const ObjectSlot& o = object(slot);
        if (!o.array) return std::nullopt;
        return o.array->key(entry(slot));
    }

    [[nodiscard]] const std::vector<MaterialSlot>& materials() const { return materials_; }
    /// In path order, lights of no energy left out (DESIGN 3, rule 3).
    [[nodiscard]] const std::vector<LightSlot>& lights() const { return lights_; }
    [[nodiscard]] SceneNames names() const;
    /// Gives numbers to the names of another scene, as there, none of which is live. Only before
    /// the first change set. Throws std::runtime_error where that is no scene's.
    void adopt(const SceneNames& names);

    /// Counts applied change sets that changed anything.
    [[nodiscard]] std::uint64_t version() const { return version_; }

  private:
    struct Prepared;
    /// Slots of an array's keys: `count` of both in a row.
    struct KeyRun {
        std::int64_t key;
        std::uint32_t slot, count;
    };
    struct Slot {
        std::uint32_t object;  ///< index into objects_
        std::uint32_t entry;   ///< of an array: place in its record, `none`: no longer there
    };
    struct Key {
        std::string path;
        bool array;
        auto operator<=>(const Key&) const = default;
    };
    [[nodiscard]] Prepared prepare(const ChangeSet& changes) const;
    [[nodiscard]] ObjectSlot compile(const std::string& path, const Object& record,
                                     Prepared& prepared) const;
    [[nodiscard]] ObjectSlot rebind(const ObjectSlot& old, const Object& record,
                                    Prepared& prepared) const;
    void compile_array(const ObjectSlot* old, const PrototypeCompiler& compiled,
                       ObjectSlot& slot) const;
    /// Null: there never was one.
    [[nodiscard]] const ObjectSlot* find(const std::string& path, bool array) const;
    [[nodiscard]] std::uint32_t index_of(const ObjectSlot& object) const;
    [[nodiscard]] std::uint32_t find_or_add(const std::string& path, bool array);
    void replace(std::uint32_t index, ObjectSlot next, AppliedChanges& applied);
    void place_entries(std::uint32_t index, ObjectSlot next, AppliedChanges& applied);
    [[nodiscard]] bool tints_vary(const CompiledPrototype& prototype) const;
    void add_keys(std::vector<KeyRun>& runs, const InstanceArray& array, std::uint32_t index);
    void rank_objects();
    void order_lights();
    [[nodiscard]] std::vector<bool> named(const std::vector<std::string>& paths) const;

    using SlotOf = std::map<std::string, std::uint32_t>;
    V3d render_origin_;
    std::vector<ObjectSlot> objects_;
    std::vector<Slot> slots_;
    std::map<Key, std::uint32_t> object_indices_;
    std::map<std::uint32_t, std::vector<KeyRun>> key_runs_;  ///< of arrays, by object; by key
    std::vector<MaterialSlot> materials_;
    SlotOf material_slots_;
    std::map<std::string, Light> light_records_;
    std::vector<LightSlot> lights_;
    std::map<std::shared_ptr<const Prototype>, std::weak_ptr<const CompiledPrototype>> prototypes_;
    std::uint64_t version_ = 0;
};

}  // namespace irt
