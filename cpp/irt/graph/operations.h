// SPDX-License-Identifier: Apache-2.0
// The arithmetic of shading nodes (docs/shading.md).
#pragma once

#include "irt/graph/value.h"
#include "irt/scene/material.h"

namespace irt::graph {

/// What `node`, neither a Primvar nor a Texture, makes of the values in its slots. Every result is
/// finite where the slots are and nothing overflows: divisions by 0, and roots, logarithms and
/// powers that are no numbers, give 0.
[[nodiscard]] Value operate(const ShadeNode& node, const std::array<Value, 4>& slots);

}  // namespace irt::graph
