// SPDX-License-Identifier: Apache-2.0
#include "irt/history/ray_trees.h"

namespace irt::history {

namespace {

template <class T>
std::size_t size_of(const std::vector<T>& v) {
    return v.capacity() * sizeof(T);
}

}  // namespace

NodeIndex RayTrees::add() {
    if (!free.empty()) {
        const NodeIndex node = free.back();
        free.pop_back();
        return node;
    }
    nodes.emplace_back();
    paths.push_back(no_path);
    objects.push_back(trace::none);
    material_bits.push_back(no_material_bit);
    marks.push_back(0);
    for (std::vector<V3f>& column : columns) column.emplace_back(0.0f);
    for (std::vector<ShadowRecord>& shadow : shadows) shadow.emplace_back();
    return static_cast<NodeIndex>(nodes.size() - 1);
}

void RayTrees::remove(NodeIndex node) {
    if (node == no_node) return;
    remove(nodes[node].reflected);
    remove(nodes[node].refracted);
    paths[node] = no_path;
    objects[node] = trace::none;
    material_bits[node] = no_material_bit;
    marks[node] = 0;
    for (std::vector<ShadowRecord>& shadow : shadows) set_shadow_path(shadow[node], no_path);
    free.push_back(node);
}

void RayTrees::set_shadow_path(ShadowRecord& record, PathIndex path) {
    shadow_rays += path != no_path;
    shadow_rays -= record.path != no_path;
    record.path = path;
}

void RayTrees::mark(NodeIndex node, std::uint8_t what) {
    marks[node] |= what | mark_walk;
    for (node = nodes[node].parent; node != no_node && !(marks[node] & mark_walk);
         node = nodes[node].parent)
        marks[node] |= mark_walk;
}

std::size_t RayTrees::bytes() const {
    std::size_t sum = size_of(nodes) + size_of(paths) + size_of(objects) + size_of(material_bits) +
                      size_of(marks) + size_of(free);
    for (const auto& column : columns) sum += size_of(column);
    for (const auto& shadow : shadows) sum += size_of(shadow);
    return sum;
}

}  // namespace irt::history
