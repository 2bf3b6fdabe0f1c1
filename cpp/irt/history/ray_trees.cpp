// SPDX-License-Identifier: Apache-2.0
#include "irt/history/ray_trees.h"

namespace irt::history {

namespace {

template <class T>
std::size_t size_of(const std::vector<T>& v) {
    return v.capacity() * sizeof(T);
}

}  // namespace

void RayTrees::reset(const std::vector<bool>& casts_shadows) {
    roots.clear();
    nodes.clear();
    paths.clear();
    marks.clear();
    points.clear();
    behind.clear();
    material_bits.clear();
    free_nodes.clear();
    free_points.clear();
    shadow_rays = 0;
    columns.resize(casts_shadows.size() + 1);
    for (Column& column : columns) {
        column.own.clear();
        column.cumulative.clear();
    }
    lights.resize(casts_shadows.size());
    for (std::size_t l = 0; l < lights.size(); ++l) {
        lights[l].casts_shadows = casts_shadows[l];
        lights[l].paths.clear();
        lights[l].occlusions.clear();
    }
}

NodeIndex RayTrees::add_node() {
    if (!free_nodes.empty()) {
        const NodeIndex node = free_nodes.back();
        free_nodes.pop_back();
        return node;
    }
    nodes.emplace_back();
    nodes.back().point = no_point;
    paths.push_back(no_path);
    marks.push_back(0);
    return static_cast<NodeIndex>(nodes.size() - 1);
}

PointIndex RayTrees::add_point(NodeIndex node) {
    PointIndex point;
    if (free_points.empty()) {
        point = static_cast<PointIndex>(points.size());
        points.emplace_back();
        behind.emplace_back();
        material_bits.push_back(no_material_bit);
        for (Column& column : columns) {
            column.own.emplace_back();
            column.cumulative.emplace_back();
        }
        for (LightNodes& light : lights)
            if (light.casts_shadows) {
                light.paths.push_back(no_path);
                light.occlusions.emplace_back();
            }
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

trace::Hit RayTrees::hit(NodeIndex index) const {
    const Node& node = nodes[index];
    trace::Hit hit;
    if (node.point == no_point) return hit;
    const KeptPoint& point = points[node.point];
    hit.t = node.t;
    hit.u = point.u;
    hit.v = point.v;
    hit.object = node.object;
    hit.part = node.part;
    hit.primitive = node.primitive;
    hit.piece = point.piece;
    return hit;
}

void RayTrees::set_hit(NodeIndex index, const trace::Hit& hit) {
    Node& node = nodes[index];
    node.t = hit.t;
    node.object = hit.object;
    node.part = hit.part;
    node.primitive = hit.primitive;
    if (!hit) return remove_point(index);
    const PointIndex at = node.point == no_point ? add_point(index) : node.point;
    KeptPoint& point = points[at];
    point.u = hit.u;
    point.v = hit.v;
    point.piece = hit.piece;
}

bool RayTrees::mark(NodeIndex node, std::uint8_t what) {
    const bool marked = marks[node] != 0;
    marks[node] |= what | mark_walk;
    if (marked) return false;
    while (!(nodes[node].parent & root_bit)) {
        node = nodes[node].parent;
        if (marks[node] != 0) return false;
        marks[node] = mark_walk;
    }
    return true;
}

SampleIndex RayTrees::sample_of(NodeIndex node) const {
    while (!(nodes[node].parent & root_bit)) node = nodes[node].parent;
    return nodes[node].parent & ~root_bit;
}

Sizes RayTrees::sizes() const {
    std::size_t intensity = 0, light = 0;
    for (const Column& column : columns) intensity += size_of(column.own) + size_of(column.cumulative);
    for (const LightNodes& l : lights) light += size_of(l.paths) + size_of(l.occlusions);
    return {{"nodes", size_of(roots) + size_of(nodes) + size_of(marks) + size_of(free_nodes)},
            {"points", size_of(points) + size_of(free_points)},
            {"hash_indices", size_of(paths)},
            {"intersections", size_of(behind)},
            {"masks", size_of(material_bits)},
            {"intensities", intensity},
            {"light_nodes", light}};
}

}  // namespace irt::history
