// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/polygon.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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
    std::vector<V2d> edges;
    for (std::size_t k = 0; k < p.size(); ++k)
        if (const V2d edge = p[(k + 1) % p.size()] - p[k]; edge != V2d(0, 0)) edges.push_back(edge);
    for (std::size_t k = 0; k < edges.size(); ++k) {
        const V2d &a = edges[k], &b = edges[(k + 1) % edges.size()];
        const double turn = a.x * b.y - a.y * b.x;
        if (turn < 0 || (turn == 0 && a.dot(b) < 0)) return false;
    }
    return true;
}

/// Shares of an edge's length that rounding may make of a touch.
constexpr double touch = 1e-12;

/// Whether the segment from `p` to `q` enters the inside of the counter-clockwise triangle abc.
bool enters(const V2d& p, const V2d& q, const V2d& a, const V2d& b, const V2d& c) {
    double first = 0, last = 1;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
        const double s = area(from, to, p), t = area(from, to, q);
        if (s <= 0 && t <= 0) return false;
        if (s < 0) first = std::max(first, s / (s - t));
        if (t < 0) last = std::min(last, s / (s - t));
    }
    return last - first > touch;
}

/// What remains of a polygon: corners by their number, counter-clockwise.
class Remainder {
  public:
    explicit Remainder(const std::vector<V2d>& points) : points_(points), left_(points.size()) {
        std::iota(left_.begin(), left_.end(), 0u);
    }
    [[nodiscard]] std::size_t size() const { return left_.size(); }
    /// Corner `i` and those beside it, the one before it first.
    [[nodiscard]] std::array<std::uint32_t, 3> ear(std::size_t i) const {
        const std::size_t n = left_.size();
        return {left_[(i + n - 1) % n], left_[i], left_[(i + 1) % n]};
    }
    void cut(std::size_t i) { left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(i)); }

    /// The first corner that can be cut off: a way back or a point twice, else a convex one whose
    /// triangle no edge enters (edges and points may touch it), else one on a straight line, else
    /// (the polygon crosses itself) any.
    [[nodiscard]] std::size_t next_ear() const {
        for (std::size_t i = 0; i < size(); ++i)
            if (turn(i) == 0 && !goes_on(i)) return i;
        for (std::size_t i = 0; i < size(); ++i)
            if (turn(i) > 0 && is_clear(i)) return i;
        for (std::size_t i = 0; i < size(); ++i)
            if (turn(i) == 0) return i;
        return 0;
    }

  private:
    [[nodiscard]] double turn(std::size_t i) const {
        const auto [a, b, c] = ear(i);
        return area(points_[a], points_[b], points_[c]);
    }
    /// Of a corner that does not turn: whether it is on the way, and no way back or standstill.
    [[nodiscard]] bool goes_on(std::size_t i) const {
        const auto [a, b, c] = ear(i);
        return (points_[b] - points_[a]).dot(points_[c] - points_[b]) > 0;
    }
    [[nodiscard]] bool is_clear(std::size_t i) const {
        const auto [a, b, c] = ear(i);
        const std::size_t n = size();
        for (std::size_t k = i + 1; k + 1 < i + n; ++k)
            if (enters(points_[left_[k % n]], points_[left_[(k + 1) % n]], points_[a], points_[b],
                       points_[c]))
                return false;
        return true;
    }

    const std::vector<V2d>& points_;
    std::vector<std::uint32_t> left_;
};

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
    Remainder left(flat);
    while (left.size() >= 3) {
        const std::size_t at = left.size() > 3 ? left.next_ear() : 1;
        const auto [a, b, c] = left.ear(at);
        triangles.push_back({first + a, first + b, first + c});
        left.cut(at);
    }
    return triangles;
}

}  // namespace irt
