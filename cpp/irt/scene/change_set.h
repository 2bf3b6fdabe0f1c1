// SPDX-License-Identifier: Apache-2.0
// The edits that lead from one state of a scene to the next (the paper's model, texture and light
// updates). A record replaces the one of the same name; an empty optional removes it.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "irt/scene/records.h"

namespace irt {

struct ChangeSet {
    std::map<std::string, std::optional<Object>> objects;      ///< by prim path
    std::map<std::string, std::optional<Material>> materials;  ///< by prim path
    std::map<std::string, std::optional<Light>> lights;        ///< by prim path

    [[nodiscard]] bool empty() const {
        return objects.empty() && materials.empty() && lights.empty();
    }
};

}  // namespace irt
