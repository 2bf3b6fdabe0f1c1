// SPDX-License-Identifier: Apache-2.0
// What a shot says can ever change, and where (DESIGN 4, "known beforehand beats found out"): found
// by walking through its change sets before the first frame is traced.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "irt/scene/change_set.h"
#include "irt/scene/scene.h"
#include "irt/trace/box.h"

namespace irt {

class Foreseen {
  public:
    /// `initial`: the change set that makes the shot's first frame from nothing.
    explicit Foreseen(const ChangeSet& initial);

    /// A later frame's changes; to be called in the order of the frames.
    void add(const ChangeSet& changes);

    /// Whether `applied`, which led to `scene` from one under `old_lights`, changes nothing but
    /// what was foreseen.
    [[nodiscard]] bool covers(const Scene& scene, const AppliedChanges& applied,
                              const std::vector<LightSlot>& old_lights) const;

    /// Whether a light comes, goes, moves or turns. Its colour and energy may change all the same.
    [[nodiscard]] bool lights_move() const { return lights_move_; }
    /// Whether an object of `scene` moves, changes its shape or its binding, comes or goes.
    [[nodiscard]] bool object_changes(const Scene& scene, std::uint32_t slot) const;
    [[nodiscard]] bool material_changes(const std::string& name) const {
        return materials_.contains(name);
    }
    /// World-space boxes of where changing objects will be, by path, those of an array's entries
    /// together; where they are now not included.
    [[nodiscard]] const std::map<std::string, std::vector<trace::Box>>& boxes() const {
        return boxes_;
    }

  private:
    /// An array: as it last was, and the keys of the entries that change.
    struct Array {
        Object last;
        std::vector<std::int64_t> keys;  ///< increasing
    };
    void add_box(const std::string& path, const trace::Box& box);
    void add_array(const std::string& path, Object now);
    [[nodiscard]] trace::Box world_box(const Object& object) const;
    [[nodiscard]] trace::Box entry_box(const Object& array, std::size_t entry) const;
    [[nodiscard]] trace::Box box_of(const std::shared_ptr<const Prototype>& prototype) const;
    [[nodiscard]] bool entry_changes(const std::string& path, std::int64_t key) const;
    [[nodiscard]] bool within(const std::string& path, const trace::Box& box) const;

    std::map<std::string, std::vector<trace::Box>> boxes_;
    std::map<std::string, Array> arrays_;
    /// In the prototypes' own spaces.
    mutable std::map<std::weak_ptr<const Prototype>, trace::Box, std::owner_less<>>
        prototype_boxes_;
    std::set<std::string> materials_;
    std::map<std::string, Light> lights_;  ///< as they last were
    bool lights_move_ = false;
};

}  // namespace irt
