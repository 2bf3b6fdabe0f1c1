// SPDX-License-Identifier: Apache-2.0
// Meshes as packets of neighbouring triangles: what one proposal of Embree's hands to the judge.
#pragma once

#include <array>
#include <vector>

#include "irt/scene/scene.h"
#include "irt/trace/box.h"
#include "irt/trace/huge_pages.h"
#include "irt/trace/judge_triangle.h"

namespace irt::trace {

/// Pairs of a packet.
inline constexpr std::size_t packet_pairs = 4;

/// Two triangles that share an edge and wind alike, or one and `none`.
using Pair = std::array<std::uint32_t, 2>;

/// The order in which `triangles` fill packets: fours of neighbouring pairs, all full but the last.
/// The order decides speed alone.
[[nodiscard]] std::vector<Pair> cluster(const Triangles& triangles);

using PacketArray = std::vector<TrianglePacket, HugePages<TrianglePacket>>;

/// Packets of the pairs in `order`.
[[nodiscard]] PacketArray make_packets(const Triangles& triangles, const std::vector<Pair>& order);

/// The box of the packet's vertices, exact.
[[nodiscard]] Box bounds(const TrianglePacket& packet);

}  // namespace irt::trace
