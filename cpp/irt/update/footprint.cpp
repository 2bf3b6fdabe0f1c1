// SPDX-License-Identifier: Apache-2.0
#include "irt/update/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "irt/mutant.h"
#include "irt/trace/judge_many.h"

namespace irt::update {

namespace {

using history::grid_side;
using history::Voxel;
using history::VoxelGrid;
using history::VoxelSet;

const double dilation = mutated(Mutant::no_dilation) ? 0 : VoxelGrid::dilation;

/// Voxels [first, last] along one axis that the stretch [lower, upper] meets, dilated; what lies
/// outside the grid is told to `voxels`.
struct Range {
    std::int32_t first, last;
};
Range range(double lower, double upper, VoxelSet& voxels) {
    lower = std::floor(lower - dilation);
    upper = std::floor(upper + dilation);
    constexpr double most = grid_side - 1.0;
    if (lower < 0 || upper > most) voxels.add_outside();
    return {static_cast<std::int32_t>(std::clamp(lower, 0.0, most + 1)),
            static_cast<std::int32_t>(std::clamp(upper, -1.0, most))};
}

/// A convex polygon of few corners: a triangle clipped by up to four planes has at most 7; rounding
/// may give it a few more.
struct Polygon {
    std::array<V3d, 12> corners = filled(V3d(0));
    std::size_t count = 0;

    static constexpr std::array<V3d, 12> filled(const V3d& p) {
        return {p, p, p, p, p, p, p, p, p, p, p, p};
    }

    void add(const V3d& p) { corners[count++] = p; }
    [[nodiscard]] Range range_along(int axis, VoxelSet& voxels) const {
        double lower = corners[0][axis], upper = lower;
        for (std::size_t i = 1; i < count; ++i) {
            lower = std::min(lower, corners[i][axis]);
            upper = std::max(upper, corners[i][axis]);
        }
        return range(lower, upper, voxels);
    }
};

/// The part of `polygon` where side * coordinate <= side * plane (Sutherland and Hodgman,
/// "Reentrant Polygon Clipping", CACM 17(1), 1974).
Polygon clipped(const Polygon& polygon, int axis, double plane, double side) {
    Polygon out;
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const V3d &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
        const double da = side * (a[axis] - plane), db = side * (b[axis] - plane);
        if (da <= 0) out.add(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            V3d p = a + (b - a) * (da / (da - db));
            p[axis] = plane;
            out.add(p);
        }
    }
    return out;
}

/// The part of `polygon` within voxel layer `i` along `axis`, dilated.
Polygon layer(const Polygon& polygon, int axis, std::int32_t i) {
    const Polygon above = clipped(polygon, axis, i - dilation, -1);
    return above.count == 0 ? above : clipped(above, axis, i + 1 + dilation, 1);
}

/// `corners` in voxels.
void add_triangle(const V3d& a, const V3d& b, const V3d& c, VoxelSet& voxels) {
    Polygon triangle;
    for (const V3d& p : {a, b, c}) triangle.add(p);
    const Range x = triangle.range_along(0, voxels);
    for (std::int32_t i = x.first; i <= x.last; ++i) {
        const Polygon slab = x.first == x.last ? triangle : layer(triangle, 0, i);
        if (slab.count == 0) continue;
        const Range y = slab.range_along(1, voxels);
        for (std::int32_t j = y.first; j <= y.last; ++j) {
            const Polygon bar = y.first == y.last ? slab : layer(slab, 1, j);
            if (bar.count == 0) continue;
            const Range z = bar.range_along(2, voxels);
            for (std::int32_t k = z.first; k <= z.last; ++k) voxels.add({i, j, k});
        }
    }
}

/// Half the lengths of the solid's box in its own space.
V3d half_lengths(const Quadric& q) {
    switch (q.kind) {
        case QuadricKind::Sphere:
            return V3d(q.radius);
        case QuadricKind::Cube:
            return V3d(q.size / 2);
        case QuadricKind::Cylinder:
        case QuadricKind::Cone:
            return {q.radius, q.radius, q.height / 2};
        case QuadricKind::Capsule:
            return {q.radius, q.radius, q.height / 2 + q.radius};
        case QuadricKind::Frustum: {
            const double radius = std::max(q.radius, q.radius_top);
            return {radius, radius, q.height / 2};
        }
        case QuadricKind::RoundCone: {
            const double radius = std::max(q.radius, q.radius_top);
            return {radius, radius, q.height / 2 + radius};
        }
        case QuadricKind::Plane:
            return {q.width / 2, q.length / 2, 0};
    }
    return V3d(0);
}

/// A parallelepiped in voxels: centre and half axes.
struct OrientedBox {
    V3d centre, axes[3];

    [[nodiscard]] double reach(const V3d& normal) const {
        return std::fabs(axes[0].dot(normal)) + std::fabs(axes[1].dot(normal)) +
               std::fabs(axes[2].dot(normal));
    }
};

/// Voxels that no face of either box parts from `box`; those of the edges' cross products are not
/// tried, which errs to the safe side.
void add_oriented_box(const OrientedBox& box, VoxelSet& voxels) {
    Range along[3]{};
    for (int a = 0; a < 3; ++a) {
        V3d unit(0);
        unit[a] = 1;
        const double reach = box.reach(unit);
        along[a] = range(box.centre[a] - reach, box.centre[a] + reach, voxels);
    }
    V3d normals[3];
    double reaches[3];
    for (int n = 0; n < 3; ++n) {
        normals[n] = box.axes[(n + 1) % 3].cross(box.axes[(n + 2) % 3]);
        const double of_voxel =
            (0.5 + dilation) *
            (std::fabs(normals[n].x) + std::fabs(normals[n].y) + std::fabs(normals[n].z));
        reaches[n] = box.reach(normals[n]) + of_voxel;
    }
    for (std::int32_t k = along[2].first; k <= along[2].last; ++k)
        for (std::int32_t j = along[1].first; j <= along[1].last; ++j)
            for (std::int32_t i = along[0].first; i <= along[0].last; ++i) {
                const V3d between = V3d(i + 0.5, j + 0.5, k + 0.5) - box.centre;
                bool apart = false;
                for (int n = 0; n < 3 && !apart; ++n)
                    apart = std::fabs(between.dot(normals[n])) > reaches[n];
                if (!apart) voxels.add({i, j, k});
            }
}

/// The box of the hull of two balls, one side along it: half axes and centre as rows. A ball of
/// radius 0 counts: where it alone is there, nothing is.
M44d box_about(const Ball& a, const Ball& b) {
    const V3d p(a.centre), q(b.centre);
    const double radius = static_cast<double>(std::max(a.radius, b.radius));
    V3d along = q - p;
    const double length = along.length();
    along = length > 0 ? along / length : V3d(0, 0, 1);
    const int least = std::fabs(along.x) < std::fabs(along.y)
                          ? (std::fabs(along.x) < std::fabs(along.z) ? 0 : 2)
                          : (std::fabs(along.y) < std::fabs(along.z) ? 1 : 2);
    V3d unit(0);
    unit[least] = 1;
    const V3d side = normalized(along.cross(unit)), other = along.cross(side),
              centre = p * 0.5 + q * 0.5;
    const V3d rows[] = {along * (length / 2 + radius), side * radius, other * radius, centre};
    M44d frame;
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 3; ++c) frame[r][c] = rows[r][c];
    return frame;
}

/// Adds what `surface` meets to `voxels`, and its bounds in voxels to `bounds`. `render_from_trace`
/// is null where trace space is render space.
void add_placed(const Surface& surface, const M44d* render_from_trace, const VoxelGrid& grid,
                VoxelSet& voxels, trace::Box& bounds) {
    const auto in_voxels = [&](const V3d& p) {
        return grid.in_voxels(render_from_trace ? transform_point(*render_from_trace, p) : p);
    };
    if (surface.triangles) {
        const Triangles& mesh = *surface.triangles;
        for (const auto& t : mesh.triangles) {
            const V3d a = in_voxels(V3d(mesh.points[t[0]])), b = in_voxels(V3d(mesh.points[t[1]])),
                      c = in_voxels(V3d(mesh.points[t[2]]));
            for (const V3d& p : {a, b, c}) bounds.extend(p);
            add_triangle(a, b, c, voxels);
        }
        return;
    }
    /// Of shape space: `frame`'s rows are the axes and the centre.
    const auto add = [&](const M44d& frame) {
        const auto corner = [&](int row) {
            V3d p(frame[3][0], frame[3][1], frame[3][2]);
            if (row < 3) p += V3d(frame[row][0], frame[row][1], frame[row][2]);
            return in_voxels(transform_point(surface.trace_from_shape, p));
        };
        OrientedBox box;
        box.centre = corner(3);
        for (int a = 0; a < 3; ++a) box.axes[a] = corner(a) - box.centre;
        for (int a = 0; a < 3; ++a) {
            V3d unit(0);
            unit[a] = 1;
            const double reach = box.reach(unit);
            bounds.lower[a] = std::min(bounds.lower[a], box.centre[a] - reach);
            bounds.upper[a] = std::max(bounds.upper[a], box.centre[a] + reach);
        }
        add_oriented_box(box, voxels);
    };
    if (surface.spheres) {
        for (const Ball& ball : surface.spheres->balls)
            if (ball.radius > 0) add(box_about(ball, ball));
    } else if (surface.curves) {
        const Curves& curves = *surface.curves;
        for (std::uint32_t k = 0; k < curves.balls.size(); ++k)
            if (const std::uint32_t next = curves.next_ball(k); next != Curves::none)
                add(box_about(curves.balls[k], curves.balls[next]));
    } else {
        const V3d half = half_lengths(surface.quadric);
        M44d frame;
        for (int a = 0; a < 3; ++a) frame[a][a] = half[a];
        add(frame);
    }
}

/// Voxels that a box may meet to stand for what is in it: so few that triangles would hardly spare
/// one.
constexpr double few_voxels = 8;

/// Whether `box` (render space) meets few voxels.
bool within_few(const trace::Box& box, const VoxelGrid& grid) {
    const V3d lower = grid.in_voxels(box.lower), upper = grid.in_voxels(box.upper);
    double count = 1;
    for (int a = 0; a < 3; ++a)
        count *= std::floor(upper[a] + dilation) - std::floor(lower[a] - dilation) + 1;
    return count <= few_voxels;
}

}  // namespace

void add_box(const trace::Box& box, const VoxelGrid& grid, VoxelSet& voxels) {
    const V3d lower = grid.in_voxels(box.lower), upper = grid.in_voxels(box.upper);
    const Range x = range(lower.x, upper.x, voxels), y = range(lower.y, upper.y, voxels),
                z = range(lower.z, upper.z, voxels);
    for (std::int32_t k = z.first; k <= z.last; ++k)
        for (std::int32_t j = y.first; j <= y.last; ++j)
            for (std::int32_t i = x.first; i <= x.last; ++i) voxels.add({i, j, k});
}

void add_surface(const Surface& surface, const VoxelGrid& grid, VoxelSet& voxels,
                 trace::Box& bounds) {
    add_placed(surface, nullptr, grid, voxels, bounds);
}

void add_instance(const CompiledPrototype& prototype, const M44d& render_from_prototype,
                  const VoxelGrid& grid, VoxelSet& voxels, trace::Box& bounds) {
    if (prototype.box.empty()) return;
    const trace::Box box = trace::transformed(prototype.box, render_from_prototype);
    if (within_few(box, grid)) {
        add_box(box, grid, voxels);
        bounds.extend(grid.in_voxels(box.lower));
        bounds.extend(grid.in_voxels(box.upper));
        return;
    }
    for (const Surface& part : prototype.surfaces)
        add_placed(part, &render_from_prototype, grid, voxels, bounds);
    for (const NestedArray& array : prototype.arrays)
        for (std::size_t entry = 0; entry < array.record->size(); ++entry)
            add_instance(array.prototype(entry),
                         array.outer_from_prototype(entry) * render_from_prototype, grid, voxels,
                         bounds);
}

void add_object(const Scene& scene, std::uint32_t slot, const VoxelGrid& grid, VoxelSet& voxels,
                trace::Box& bounds) {
    if (const CompiledPrototype* prototype = scene.prototype(slot))
        add_instance(*prototype, scene.render_from_prototype(slot), grid, voxels, bounds);
    else
        add_surface(scene.object(slot).surface, grid, voxels, bounds);
}

Footprints::Footprints(const VoxelGrid& grid, std::size_t objects)
    : grid_(grid), apart_(objects <= few) {}

template <class Add>
void Footprints::add_one(Add&& add) {
    if (!apart_) return add(together_, bounds_);
    VoxelSet voxels;
    trace::Box bounds;
    add(voxels, bounds);
    regions_.add(voxels, bounds);
}

void Footprints::add(const Scene& scene, std::uint32_t slot) {
    if (!scene.live(slot)) return;
    add_one([&](VoxelSet& voxels, trace::Box& bounds) {
        add_object(scene, slot, grid_, voxels, bounds);
    });
}

void Footprints::add(const ObjectSlot& previous) {
    add_one([&](VoxelSet& voxels, trace::Box& bounds) {
        if (previous.prototype)
            add_instance(*previous.prototype, previous.render_from_prototype, grid_, voxels,
                         bounds);
        else
            add_surface(previous.surface, grid_, voxels, bounds);
    });
}

void Footprints::add(const FormerEntries& former) {
    for (const std::uint32_t entry : former.entries)
        add_one([&](VoxelSet& voxels, trace::Box& bounds) {
            add_instance(former.array.prototype_of(entry), former.array.render_from_entry(entry),
                         grid_, voxels, bounds);
        });
}

history::Regions Footprints::regions() const {
    history::Regions all = regions_;
    if (!apart_) all.add(together_, bounds_);
    return all;
}

}  // namespace irt::update
