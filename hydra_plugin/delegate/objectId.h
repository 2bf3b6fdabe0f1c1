// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <murmurhash.h>

/// What id AOVs show of an object of that name (irt::ObjectSlot::id).
inline std::uint32_t HdIrtObjectId(const std::string& name) {
    std::uint32_t id = 0;
    lmmh_x86_32(name.data(), static_cast<std::uint32_t>(name.size()), 0, &id);
    return id;
}
