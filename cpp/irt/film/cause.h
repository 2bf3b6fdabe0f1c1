// SPDX-License-Identifier: Apache-2.0
// What had a pixel changed, as a number that the renderer can put a name to.
#pragma once

#include <cstdint>

namespace irt::film {

enum class CauseKind : std::uint32_t {
    None,
    Everything,  ///< a full trace
    Object,      ///< by slot: it moved, came, went, changed its shape or what it wears
    Material,    ///< by slot
    Light,       ///< by place among the lights that the update changed
    Shadow,      ///< of something that lets light through
};

using CauseCode = std::uint32_t;
inline constexpr unsigned cause_kind_shift = 29;

[[nodiscard]] constexpr CauseCode make_cause(CauseKind kind, std::uint32_t index = 0) {
    return static_cast<std::uint32_t>(kind) << cause_kind_shift | index;
}
[[nodiscard]] constexpr CauseKind cause_kind(CauseCode cause) {
    return static_cast<CauseKind>(cause >> cause_kind_shift);
}
[[nodiscard]] constexpr std::uint32_t cause_index(CauseCode cause) {
    return cause & ((1u << cause_kind_shift) - 1);
}

}  // namespace irt::film
