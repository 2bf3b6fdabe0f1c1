// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/polygon.h"

#include <cmath>

namespace irt {

namespace {

/// Twice the signed area of abc.
double area(const V2d& a, const V2d& b, const V2d& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The face seen along its normal, so that it winds counter-clockwise.
std::vector<V2d> flattened(const Mesh& mesh, std::uint32_t first, std::uint32_t count) {
    const auto corner = [&](std::uint32_t k) {
        return V3d(
            mesh.points[static_cast<std::size_t>(mesh.face_vertex_indices[first + k % count])]);
    };
    V3d normal{0, 0, 0};
    for (std::uint32_t k = 0; k < count; ++k) {
        const V3d a = corner(k) - corner(0), b = corner(k + 1) - corner(0);
        normal += a.cross(b);
    }
    int z = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (std::fabs(normal[axis]) > std::fabs(normal[z])) z = axis;
    const int x = (z + (normal[z] < 0 ? 2 : 1)) % 3, y = (z + (normal[z] < 0 ? 1 : 2)) % 3;
    std::vector<V2d> flat;
    for (std::uint32_t k = 0; k < count; ++k) flat.emplace_back(corner(k)[x], corner(k)[y]);
    return flat;
}

bool convex(const std::vector<V2d>& p) {
    const std::size_t n = p.size();
    for (std::size_t k = 0; k < n; ++k)
        if (area(p[k], p[(k + 1) % n], p[(k + 2) % n]) < 0) return false;
    return true;
}

/// Whether corner `i` of the remaining polygon `left` is an ear: convex, and empty of the others.
bool is_ear(const std::vector<V2d>& p, const std::vector<std::uint32_t>& left, std::size_t i) {
    const std::size_t n = left.size();
    const V2d &a = p[left[(i + n - 1) % n]], &b = p[left[i]], &c = p[left[(i + 1) % n]];
    if (!(area(a, b, c) > 0)) return false;
    for (std::size_t k = 0; k < n; ++k) {
        const V2d& q = p[left[k]];
        if (q == a || q == b || q == c) continue;
        if (area(a, b, q) >= 0 && area(b, c, q) >= 0 && area(c, a, q) >= 0) return false;
    }
    return true;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate_polygon(const Mesh& mesh, std::uint32_t first,
                                                              std::uint32_t count) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    if (count < 3) return triangles;
    std::vector<V2d> flat;
    if (count > 3) flat = flattened(mesh, first, count);
    if (count == 3 || convex(flat)) {
        for (std::uint32_t k = 1; k + 1 < count; ++k)
            triangles.push_back({first, first + k, first + k + 1});
        return triangles;
    }
    std::vector<std::uint32_t> left(count);
    for (std::uint32_t k = 0; k < count; ++k) left[k] = k;
    while (left.size() > 3) {
        std::size_t ear = 0;
        while (ear < left.size() && !is_ear(flat, left, ear)) ++ear;
        if (ear == left.size()) ear = 0;  // crosses itself, or flat: any cut will do
        const std::size_t n = left.size();
        triangles.push_back(
            {first + left[(ear + n - 1) % n], first + left[ear], first + left[(ear + 1) % n]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({first + left[0], first + left[1], first + left[2]});
    return triangles;
}

}  // namespace irt
