// SPDX-License-Identifier: Apache-2.0
// Transforms and shapes, some of them hostile, that the trace tests and the exact-hits trial share.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "irt/scene/records.h"
#include "irt/scene/ribbons.h"

namespace irt::test {

inline M44d translation(const V3d& t) {
    M44d m;
    for (int a = 0; a < 3; ++a) m[3][a] = t[a];
    return m;
}

inline M44d scaling(const V3d& s) {
    M44d m;
    for (int a = 0; a < 3; ++a) m[a][a] = s[a];
    return m;
}

/// Rotation by `angle` about `axis` (0, 1, 2).
inline M44d rotation(int axis, double angle) {
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    M44d m;
    m[i][i] = m[j][j] = std::cos(angle);
    m[i][j] = std::sin(angle);
    m[j][i] = -std::sin(angle);
    return m;
}

/// Uniform in (-1, 1).
class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double operator()() { return std::uniform_real_distribution<double>(-1, 1)(engine_); }
    std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
    V3d point() {
        const double x = (*this)(), y = (*this)(), z = (*this)();
        return {x, y, z};
    }
    V3d direction() {
        for (;;) {
            const V3d p = point();
            const double l = p.length();
            if (l > 1e-3 && l <= 1) return p / l;
        }
    }
    /// Rotated, scaled within an octave (mirrored once in four), moved within `spread`.
    M44d transform(double spread) {
        V3d s(std::exp2(0.5 * (*this)()), std::exp2(0.5 * (*this)()), std::exp2(0.5 * (*this)()));
        if (below(4) == 0) s.x = -s.x;
        M44d m = scaling(s);
        for (int axis = 0; axis < 3; ++axis) m = m * rotation(axis, 3.2 * (*this)());
        return m * translation(point() * spread);
    }

  private:
    std::mt19937_64 engine_;
};

inline void add_triangle(Mesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c) {
    mesh.face_vertex_counts.push_back(3);
    mesh.face_vertex_indices.insert(mesh.face_vertex_indices.end(), {a, b, c});
}

/// A closed surface of revolution about z, welded: `profile(h)`, h in [0, 1], is (radius, z) and
/// has radius 0 at both ends. Outward is counter-clockwise.
template <class Profile>
std::shared_ptr<Mesh> lathe(int rows, int columns, Profile&& profile) {
    auto mesh = std::make_shared<Mesh>();
    const auto vertex = [&](int row, int column) {
        if (row == 0) return 0;
        if (row == rows) return (rows - 1) * columns + 1;
        return 1 + (row - 1) * columns + column % columns;
    };
    for (int row = 0; row <= rows; ++row) {
        const V2d p = profile(static_cast<double>(row) / rows);
        for (int column = 0; column < (row == 0 || row == rows ? 1 : columns); ++column) {
            const double angle = 2 * 3.14159265358979323846 * column / columns;
            mesh->points.emplace_back(V3f(V3d(p.x * std::cos(angle), p.x * std::sin(angle), p.y)));
        }
    }
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const int a = vertex(row, column), b = vertex(row, column + 1),
                      c = vertex(row + 1, column), d = vertex(row + 1, column + 1);
            if (row > 0) add_triangle(*mesh, a, b, row + 1 < rows ? d : c);
            if (row + 1 < rows) add_triangle(*mesh, a, d, c);
        }
    return mesh;
}

inline std::shared_ptr<Mesh> ball(int rows, int columns, double radius = 1) {
    return lathe(rows, columns, [radius](double h) {
        const double angle = 3.14159265358979323846 * h;
        const bool pole = h == 0 || h == 1;
        return V2d(pole ? 0 : radius * std::sin(angle), -radius * std::cos(angle));
    });
}

/// A chessman of sorts, `size` wide and 2 * `size` high, standing on z = 0.
inline std::shared_ptr<Mesh> pawn(int rows, int columns, double size = 1) {
    return lathe(rows, columns, [size](double h) {
        const bool pole = h == 0 || h == 1;
        return V2d(pole ? 0 : size * (0.45 - 0.3 * h + 0.12 * std::sin(9 * h)), h * 2 * size);
    });
}

/// `n` by `n` aligned squares of side `step` on z = 0 about the origin; two triangles each.
inline std::shared_ptr<Mesh> board(int n, double step) {
    auto mesh = std::make_shared<Mesh>();
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            mesh->points.emplace_back(V3f(V3d((i - n / 2) * step, (j - n / 2) * step, 0)));
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const int a = i * (n + 1) + j, b = a + 1, c = a + n + 1, d = c + 1;
            add_triangle(*mesh, a, c, b);
            add_triangle(*mesh, b, c, d);
        }
    return mesh;
}

/// A closed box [-1, 1]^3 of quads.
inline std::shared_ptr<Mesh> box() {
    auto mesh = std::make_shared<Mesh>();
    for (int i = 0; i < 8; ++i)
        mesh->points.emplace_back(static_cast<float>(i & 1 ? 1 : -1),
                                  static_cast<float>(i & 2 ? 1 : -1),
                                  static_cast<float>(i & 4 ? 1 : -1));
    mesh->face_vertex_counts.assign(6, 4);
    mesh->face_vertex_indices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    return mesh;
}

inline Quadric quadric(QuadricKind kind) {
    Quadric q;
    q.kind = kind;
    q.radius_top = 0.375;
    return q;
}

inline const std::vector<std::pair<QuadricKind, const char*>>& quadric_kinds() {
    static const std::vector<std::pair<QuadricKind, const char*>> kinds{
        {QuadricKind::Sphere, "sphere"},     {QuadricKind::Cube, "cube"},
        {QuadricKind::Cylinder, "cylinder"}, {QuadricKind::Cone, "cone"},
        {QuadricKind::Capsule, "capsule"},   {QuadricKind::Plane, "plane"},
        {QuadricKind::Frustum, "frustum"},   {QuadricKind::RoundCone, "round cone"}};
    return kinds;
}

/// Balls within [-1, 1]^3: some alike, some within others, some of radius 0, some on a grid.
inline std::shared_ptr<Spheres> cloud(Random& random, std::size_t count) {
    auto spheres = std::make_shared<Spheres>();
    for (std::size_t i = 0; i < count; ++i) {
        Ball ball{V3f(random.point()), static_cast<float>(0.25 + 0.2 * random())};
        if (i % 5 == 1) ball.radius = 0;
        if (i % 5 == 2) ball.centre = {0, std::round(ball.centre.y * 2) / 2, 0.5f};
        if (i % 5 == 3) ball = spheres->balls[random.below(i)];
        if (i % 5 == 4) ball = {spheres->balls[random.below(i)].centre, 0.0625f};
        spheres->balls.push_back(ball);
    }
    return spheres;
}

/// Curves of `balls` each within [-1, 1]^3: sharp turns, straight runs, balls that hold their
/// neighbours, points twice in a row, tips of radius 0.
inline std::shared_ptr<Curves> strands(Random& random, std::uint32_t count, std::uint32_t balls,
                                       bool closed, double radius = 0.15) {
    auto curves = std::make_shared<Curves>();
    curves->closed = closed;
    curves->firsts.push_back(0);
    for (std::uint32_t c = 0; c < count; ++c) {
        V3f at(random.point() * 0.5), step(random.point() * 0.25);
        for (std::uint32_t i = 0; i < balls; ++i) {
            auto r = static_cast<float>(radius * (1 + 0.7 * random()));
            if (random.below(3) == 0) step = V3f(random.point() * 0.3);
            if (random.below(6) == 0) step = {0.25f, 0, 0};
            if (random.below(8) == 0) r *= 3;
            if (i + 1 == balls && c % 2 == 0) r = 0;
            if (random.below(8) != 0) at += step;
            curves->balls.push_back({at, r});
            curves->curve_of.push_back(c);
        }
        curves->firsts.push_back(static_cast<std::uint32_t>(curves->balls.size()));
    }
    return curves;
}

/// Ribbons within [-1, 1]^3 along curves of sharp turns and points twice in a row, twisted.
inline std::shared_ptr<const Mesh> bands(Random& random, std::int32_t count, bool closed) {
    ControlCurves curves;
    curves.basis = CurveBasis::CatmullRom;
    curves.wrap = closed ? CurveWrap::Periodic : CurveWrap::Pinned;
    curves.vertex_counts.assign(static_cast<std::size_t>(count), 5);
    curves.widths_interpolation = curves.normals_interpolation = Interpolation::Vertex;
    for (std::int32_t i = 0; i < 5 * count; ++i) {
        curves.points.push_back(i % 5 != 0 && random.below(6) == 0 ? curves.points.back()
                                                                   : V3f(random.point()));
        curves.widths.push_back(static_cast<float>(0.2 + 0.2 * random()));
        curves.normals.emplace_back(V3f(random.direction()));
    }
    return make_ribbons(curves, 4);
}

/// A ribbon around the z axis, closed above and below by polygons of its edges' points.
inline std::shared_ptr<const Mesh> drum(int sides) {
    ControlCurves curves;
    curves.wrap = CurveWrap::Periodic;
    curves.vertex_counts = {sides};
    curves.widths = {2};
    curves.normals_interpolation = Interpolation::Vertex;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / sides;
        curves.points.emplace_back(V3f(V3d(std::cos(angle), std::sin(angle), 0)));
        curves.normals.push_back(curves.points.back());
    }
    auto mesh = std::make_shared<Mesh>(*make_ribbons(curves, 1));
    for (const int edge : {0, 1}) {
        mesh->face_vertex_counts.push_back(sides);
        for (int i = 0; i < sides; ++i) mesh->face_vertex_indices.push_back(2 * i + edge);
    }
    return mesh;
}

/// Any geometry but meshes and instances.
inline Geometry random_solid(Random& random) {
    const std::size_t k = random.below(quadric_kinds().size() + 3);
    if (k < quadric_kinds().size()) return quadric(quadric_kinds()[k].first);
    if (k == quadric_kinds().size())
        return std::shared_ptr<const Spheres>(cloud(random, random.below(12)));
    return std::shared_ptr<const Curves>(
        strands(random, 1 + static_cast<std::uint32_t>(random.below(3)), 5, random.below(2) == 0));
}

}  // namespace irt::test
