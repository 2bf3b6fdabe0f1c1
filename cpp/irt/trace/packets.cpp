// SPDX-License-Identifier: Apache-2.0
#include "irt/trace/packets.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace irt::trace {
namespace {

/// Pairs of a range that is split by trying every cut; longer ones are cut at the median.
constexpr std::size_t sweep_limit = 128;

struct FloatBox {
    V3f lower{std::numeric_limits<float>::max()}, upper{-std::numeric_limits<float>::max()};

    void extend(const FloatBox& b) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = std::min(lower[a], b.lower[a]);
            upper[a] = std::max(upper[a], b.upper[a]);
        }
    }
    [[nodiscard]] float area() const {
        const V3f d = upper - lower;
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

struct Item {
    FloatBox box;
    V3f centre;
    Pair pair;
};

void sort_along(Item* begin, Item* end, int axis) {
    std::sort(begin, end, [axis](const Item& a, const Item& b) {
        return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.pair < b.pair;
    });
}

/// Orders [begin, end) so that each run of packet_pairs, counted from begin, is compact: cuts fall
/// on multiples of that, chosen by summed surface area.
void arrange(Item* begin, Item* end) {
    const auto count = static_cast<std::size_t>(end - begin);
    if (count <= packet_pairs) return;
    if (count > sweep_limit) {
        FloatBox centres;
        for (const Item* i = begin; i != end; ++i) centres.extend({i->centre, i->centre});
        const V3f extent = centres.upper - centres.lower;
        const int axis =
            extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);
        Item* middle = begin + count / (2 * packet_pairs) * packet_pairs;
        std::nth_element(begin, middle, end, [axis](const Item& a, const Item& b) {
            return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis]
                                                    : a.pair < b.pair;
        });
        arrange(begin, middle);
        arrange(middle, end);
        return;
    }
    float best = std::numeric_limits<float>::infinity();
    int best_axis = 0;
    std::size_t best_cut = packet_pairs;
    float right_area[sweep_limit];
    for (int axis = 0; axis < 3; ++axis) {
        sort_along(begin, end, axis);
        FloatBox right;
        for (std::size_t i = count; i-- > packet_pairs;) {
            right.extend(begin[i].box);
            right_area[i] = right.area();
        }
        FloatBox left;
        for (std::size_t i = 0; i + 1 < count; ++i) {
            left.extend(begin[i].box);
            const std::size_t cut = i + 1;
            if (cut % packet_pairs != 0) continue;
            const float cost =
                left.area() * static_cast<float>(cut / packet_pairs) +
                right_area[cut] *
                    static_cast<float>((count - cut + packet_pairs - 1) / packet_pairs);
            if (cost < best) best = cost, best_axis = axis, best_cut = cut;
        }
    }
    if (best_axis != 2) sort_along(begin, end, best_axis);
    arrange(begin, begin + best_cut);
    arrange(begin + best_cut, end);
}

/// Two edges are one, walked in the two ways, where `from` and `to` are swapped.
struct HalfEdge {
    std::uint32_t from, to, triangle;

    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> key() const {
        return std::minmax(from, to);
    }
};

/// The vertices at which to begin `a` and `b` so that they are (0, 1, 2) and (0, 2, 3) of one pair;
/// nothing if they share no edge that both walk counter-clockwise.
using Turns = std::array<std::size_t, 2>;
std::optional<Turns> align(const std::array<std::uint32_t, 3>& a,
                           const std::array<std::uint32_t, 3>& b) {
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            if (a[i] == b[j] && a[(i + 2) % 3] == b[(j + 1) % 3]) return Turns{i, j};
    return std::nullopt;
}

/// Pairs neighbours in the file first (the fans of polygons), then what edges are left.
std::vector<Pair> make_pairs(const Triangles& mesh) {
    const std::size_t count = mesh.triangles.size();
    std::vector<Pair> pairs;
    pairs.reserve(count / 2 + 1);
    std::vector<HalfEdge> left;
    for (std::size_t i = 0; i < count; ++i) {
        const auto triangle = static_cast<std::uint32_t>(i);
        if (i + 1 < count && align(mesh.triangles[i], mesh.triangles[i + 1])) {
            pairs.push_back({triangle, triangle + 1});
            ++i;
            continue;
        }
        for (std::size_t k = 0; k < 3; ++k)
            left.push_back({mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3], triangle});
    }
    std::sort(left.begin(), left.end(), [](const HalfEdge& a, const HalfEdge& b) {
        return a.key() != b.key() ? a.key() < b.key() : a.triangle < b.triangle;
    });
    std::vector<bool> paired(count, false);
    for (std::size_t i = 0; i + 1 < left.size(); ++i) {
        const HalfEdge &a = left[i], &b = left[i + 1];
        if (a.key() != b.key() || a.triangle == b.triangle || paired[a.triangle] ||
            paired[b.triangle] || !align(mesh.triangles[a.triangle], mesh.triangles[b.triangle]))
            continue;
        pairs.push_back({a.triangle, b.triangle});
        paired[a.triangle] = paired[b.triangle] = true;
    }
    for (const HalfEdge& edge : left) {
        if (paired[edge.triangle]) continue;
        paired[edge.triangle] = true;
        pairs.push_back({edge.triangle, none});
    }
    return pairs;
}

}  // namespace

std::vector<Pair> cluster(const Triangles& triangles) {
    std::vector<Pair> pairs = make_pairs(triangles);
    std::vector<Item> items(pairs.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
        Item& item = items[i];
        item.pair = pairs[i];
        for (const std::uint32_t triangle : item.pair)
            if (triangle != none)
                for (const std::uint32_t p : triangles.triangles[triangle])
                    item.box.extend({triangles.points[p], triangles.points[p]});
        item.centre = item.box.lower * 0.5f + item.box.upper * 0.5f;
    }
    arrange(items.data(), items.data() + items.size());
    for (std::size_t i = 0; i < items.size(); ++i) pairs[i] = items[i].pair;
    return pairs;
}

PacketArray make_packets(const Triangles& triangles, const std::vector<Pair>& order) {
    PacketArray packets((order.size() + packet_pairs - 1) / packet_pairs);
    constexpr float absent = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 0; i < packets.size() * packet_pairs; ++i) {
        TrianglePacket& packet = packets[i / packet_pairs];
        const std::size_t lane = i % packet_pairs;
        const Pair pair = i < order.size() ? order[i] : Pair{none, none};
        std::uint32_t vertices[4] = {none, none, none, none};
        Turns first{0, 0};
        if (pair[1] != none)
            first = align(triangles.triangles[pair[0]], triangles.triangles[pair[1]]).value();
        for (std::size_t side = 0; side < 2; ++side) {
            packet.primitive[side][lane] = pair[side];
            if (pair[side] == none) continue;
            const auto turn = static_cast<std::uint32_t>((3 - first[side]) % 3);
            packet.primitive[side][lane] |= turn << TrianglePacket::turn_shift;
            for (std::size_t k = 0; k < 3; ++k)
                vertices[TrianglePacket::corner[side][k]] =
                    triangles.triangles[pair[side]][(first[side] + k) % 3];
        }
        for (std::size_t k = 0; k < 4; ++k)
            for (int a = 0; a < 3; ++a)
                packet.vertex[k][a][lane] =
                    vertices[k] == none ? absent : triangles.points[vertices[k]][a];
    }
    return packets;
}

Box bounds(const TrianglePacket& packet) {
    Box box;
    for (int lane = 0; lane < 4; ++lane)
        for (int v = 0; v < 4; ++v) {
            const V3f p = packet.point(v, lane);
            if (p.x == p.x) box.extend(V3d(p));
        }
    return box;
}

}  // namespace irt::trace
