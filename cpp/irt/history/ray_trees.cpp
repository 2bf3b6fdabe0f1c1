// SPDX-License-Identifier: Apache-2.0
#include "irt/history/ray_trees.h"

namespace irt::history {

namespace {

template <class T>
std::size_t size_of(const Array<T>& v) {
    return v.capacity() * sizeof(T);
}

/// Fetches the line that the next but one elements will be written to: cells are recorded side by
/// side, so that no processor foresees where the next write goes, and writes that wait stop it.
template <class T>
void fetch_next(const Array<T>& v) {
    __builtin_prefetch(reinterpret_cast<const char*>(v.data() + v.size()) + 64, 1);
}

/// Appends, growing by an eighth: a history that doubled would hold as much in vain.
template <class T>
void append(Array<T>& v, const T& value) {
    if (v.size() == v.capacity()) v.reserve(v.size() + v.size() / 8 + 64);
    v.push_back(value);
}

/// Room for as many as the like has and a sixteenth more: cells hold alike to a few hundredths, and
/// updates add a little.
std::size_t room_like(std::size_t count) { return count + count / 16 + 64; }

}  // namespace

RayTrees::RayTrees(const std::vector<bool>& casts_shadows, bool emission,
                   std::pmr::memory_resource* memory)
    : roots(memory),
      nodes(memory),
      paths(memory),
      marks(memory),
      points(memory),
      behind(memory),
      material_bits(memory),
      emits(emission) {
    for (std::size_t c = 0; c <= casts_shadows.size(); ++c) {
        columns.emplace_back(memory);
        settled.emplace_back();
    }
    for (const bool shadows : casts_shadows) lights.emplace_back(shadows, memory);
}

void RayTrees::start_emission() {
    emits = true;
    columns[0].assign(points.size(), Intensity());
    settled[0].assign(settled_count, V3f(0, 0, 0));
}

void RayTrees::reserve_like(const RayTrees& like) {
    const std::size_t node_room = room_like(like.nodes.size()),
                      point_room = room_like(like.points.size());
    roots.reserve(room_like(like.roots.size()));
    nodes.reserve(node_room);
    paths.reserve(node_room);
    marks.reserve(node_room);
    points.reserve(point_room);
    behind.reserve(point_room);
    material_bits.reserve(point_room);
    for (std::size_t c = emits ? 0 : 1; c < columns.size(); ++c) {
        columns[c].reserve(point_room);
    }
    for (LightNodes& light : lights) {
        if (!light.casts_shadows) continue;
        light.paths.reserve(point_room);
        light.occlusions.reserve(point_room);
    }
}

std::size_t RayTrees::bytes_like(const RayTrees& like) {
    std::size_t of_point = sizeof(KeptPoint) + sizeof(HitBehind) + sizeof(std::uint8_t) +
                           (like.columns.size() - (like.emits ? 0 : 1)) * sizeof(Intensity);
    for (const LightNodes& light : like.lights)
        if (light.casts_shadows) of_point += sizeof(PathIndex) + sizeof(trace::Occlusion);
    const std::size_t of_node = sizeof(Node) + sizeof(PathIndex) + sizeof(std::uint8_t);
    const std::size_t arrays = 8 + 2 * (like.columns.size() + like.lights.size());
    return room_like(like.roots.size()) * sizeof(NodeIndex) +
           room_like(like.nodes.size()) * of_node + room_like(like.points.size()) * of_point +
           arrays * alignof(std::max_align_t);
}

NodeIndex RayTrees::add_node() {
    if (!free_nodes.empty()) {
        const NodeIndex node = free_nodes.back();
        free_nodes.pop_back();
        return node;
    }
    append(nodes, Node());
    nodes.back().point = no_point;
    append(paths, no_path);
    append(marks, std::uint8_t{0});
    fetch_next(nodes);
    fetch_next(paths);
    return static_cast<NodeIndex>(nodes.size() - 1);
}

PointIndex RayTrees::add_point(NodeIndex node) {
    PointIndex point;
    if (free_points.empty()) {
        point = static_cast<PointIndex>(points.size());
        append(points, KeptPoint());
        append(behind, HitBehind());
        append(material_bits, no_material_bit);
        for (std::size_t c = emits ? 0 : 1; c < columns.size(); ++c) {
            append(columns[c], Intensity());
            fetch_next(columns[c]);
        }
        for (LightNodes& light : lights)
            if (light.casts_shadows) {
                append(light.paths, no_path);
                append(light.occlusions, trace::Occlusion());
                fetch_next(light.paths);
                fetch_next(light.occlusions);
            }
        fetch_next(points);
        fetch_next(behind);
    } else {
        point = free_points.back();
        free_points.pop_back();
    }
    points[point].node = node;
    points[point].branches[0] = points[point].branches[1] = no_node;
    nodes[node].point = point;
    return point;
}

void RayTrees::remove(NodeIndex node) {
    if (node == no_node) return;
    remove_point(node);
    paths[node] = no_path;
    marks[node] = 0;
    free_nodes.push_back(node);
}

void RayTrees::remove_point(NodeIndex node) {
    const PointIndex point = std::exchange(nodes[node].point, no_point);
    if (point == no_point) return;
    for (const NodeIndex branch : points[point].branches) remove(branch);
    points[point].node = no_node;
    material_bits[point] = no_material_bit;
    for (std::size_t l = 0; l < lights.size(); ++l) set_shadow_path(l, point, no_path);
    free_points.push_back(point);
}

void RayTrees::set_shadow_path(std::size_t light, PointIndex point, PathIndex path) {
    if (!lights[light].casts_shadows) return;
    PathIndex& kept = lights[light].paths[point];
    shadow_rays += path != no_path;
    shadow_rays -= kept != no_path;
    kept = path;
}

void RayTrees::set_hit(NodeIndex index, const trace::Hit& hit) {
    Node& node = nodes[index];
    node.t = hit.t;
    node.visible = trace::HitName(hit);
    if (!hit) return remove_point(index);
    const PointIndex point = node.point == no_point ? add_point(index) : node.point;
    points[point].piece = hit.piece;
}

void RayTrees::settle(SampleIndex first, const End& end, const SeenBeyond& seen_beyond) {
    settled_rays += rays() - end.rays;
    for (SampleIndex sample = first; sample < roots.size(); ++sample) {
        const NodeIndex root = roots[sample];
        const PointIndex point = nodes[root].point;
        for (std::size_t c = emits ? 0 : 1; c < columns.size(); ++c)
            settled[c].push_back(point == no_point ? seen_beyond(c, root)
                                                   : columns[c][point].cumulative);
        roots[sample] = settled_bit | settled_count++;
    }
    for (LightNodes& light : lights) {
        if (!light.casts_shadows) continue;
        for (std::size_t p = end.points; p < points.size(); ++p)
            shadow_rays -= light.paths[p] != no_path;
        light.paths.resize(end.points);
        light.occlusions.resize(end.points);
    }
    nodes.resize(end.nodes);
    paths.resize(end.nodes);
    marks.resize(end.nodes);
    points.resize(end.points);
    behind.resize(end.points);
    material_bits.resize(end.points);
    for (std::size_t c = emits ? 0 : 1; c < columns.size(); ++c) {
        columns[c].resize(end.points);
    }
}

bool RayTrees::mark(NodeIndex node, std::uint8_t what) {
    const bool marked = marks[node] != 0;
    marks[node] |= what | mark_walk;
    if (marked) return false;
    while (!is_root(node)) {
        node = parent(node);
        if (marks[node] != 0) return false;
        marks[node] = mark_walk;
    }
    return true;
}

SampleIndex RayTrees::sample_of(NodeIndex node) const {
    while (!is_root(node)) node = parent(node);
    return nodes[node].parent & ~root_bit;
}

Sizes RayTrees::sizes() const {
    std::size_t intensity = 0, light = 0, of_settled = 0;
    for (const Array<V3f>& column : settled) of_settled += size_of(column);
    for (const Column& column : columns) intensity += size_of(column);
    for (const LightNodes& l : lights) light += size_of(l.paths) + size_of(l.occlusions);
    return {{"nodes", size_of(roots) + size_of(nodes) + size_of(marks) + size_of(free_nodes)},
            {"points", size_of(points) + size_of(free_points)},
            {"hash_indices", size_of(paths)},
            {"intersections", size_of(behind)},
            {"masks", size_of(material_bits)},
            {"intensities", intensity},
            {"light_nodes", light},
            {"settled", of_settled}};
}

}  // namespace irt::history
