// SPDX-License-Identifier: Apache-2.0
// Scenes and rays that the trace tests and the exact-hits trial share.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "irt/scene/scene.h"
#include "irt/trace/intersector.h"

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

/// Any geometry but meshes and instances.
inline Geometry random_solid(Random& random) {
    const std::size_t k = random.below(quadric_kinds().size() + 3);
    if (k < quadric_kinds().size()) return quadric(quadric_kinds()[k].first);
    if (k == quadric_kinds().size())
        return std::shared_ptr<const Spheres>(cloud(random, random.below(12)));
    return std::shared_ptr<const Curves>(
        strands(random, 1 + static_cast<std::uint32_t>(random.below(3)), 5, random.below(2) == 0));
}

/// Collects objects of three materials ("opaque", "glass", "red glass") and makes the scene.
class SceneBuilder {
  public:
    SceneBuilder() {
        Material opaque, glass, red;
        glass.opacity = 0;
        glass.diffuse_color = V3f(0.5f, 0.25f, 0.75f);
        red.opacity = 0.25f;
        red.diffuse_color = V3f(1, 0.5f, 0);
        changes_.materials = {{"opaque", opaque}, {"glass", glass}, {"red glass", red}};
    }
    void add(Geometry geometry, const M44d& world_from_object,
             const std::string& material = "opaque") {
        changes_.objects["/o" + std::to_string(count_++)] =
            Object{std::move(geometry), world_from_object, material};
    }
    [[nodiscard]] const ChangeSet& changes() const { return changes_; }
    [[nodiscard]] std::unique_ptr<Scene> scene(const V3d& render_origin = V3d(0, 0, 0)) const {
        auto scene = std::make_unique<Scene>(render_origin);
        scene->apply(changes_);
        return scene;
    }

  private:
    ChangeSet changes_;
    int count_ = 0;
};

inline Affine affine(const M44d& m) {
    Affine rows;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 3; ++j) rows[static_cast<std::size_t>(3 * i + j)] = m[i][j];
    return rows;
}

using PrototypePointer = std::shared_ptr<const Prototype>;
using ArrayPointer = std::shared_ptr<const InstanceArray>;

inline PrototypePointer prototype(std::vector<Part> parts) {
    return std::make_shared<const Prototype>(Prototype{std::move(parts)});
}

/// Tiles that meet edge to edge on z = 0, some of them twice.
inline ArrayPointer tile_array() {
    auto array = std::make_shared<InstanceArray>();
    const std::shared_ptr<const Mesh> tile = board(4, 0.5);
    array->prototypes = {prototype({{"tile", tile, M44d(), "opaque"}}),
                         prototype({{"tile", tile, M44d(), "red glass"}})};
    for (int i = 0; i < 64; ++i)
        for (int copy = 0; copy < (i % 7 == 0 ? 2 : 1); ++copy) {
            array->array_from_prototype.push_back(
                affine(translation({(i % 8) * 2.0 - 7, (i / 8) * 2.0 - 7, 0})));
            array->prototype_of.push_back(i % 3 == 0 ? 1 : 0);
        }
    return array;
}

/// Of three prototypes, in place and size at random, some coincident, with keys that leave gaps.
inline std::shared_ptr<InstanceArray> random_array(Random& random, int count) {
    auto array = std::make_shared<InstanceArray>();
    const std::shared_ptr<const Mesh> mesh = ball(6, 8), cube = box();
    array->prototypes = {
        prototype({{"mesh", mesh, M44d(), "opaque"},
                   {"cone", quadric(QuadricKind::Cone), translation({0, 2, 0}), "red glass"}}),
        prototype({{"sphere", quadric(QuadricKind::Sphere), M44d(), "glass"}}),
        prototype({{"box", cube, scaling(V3d(0.5)), "opaque"}})};
    for (int i = 0; i < count; ++i) {
        const V3d p = random.point() * 5;
        array->array_from_prototype.push_back(
            i > 0 && random.below(4) == 0 ? array->array_from_prototype.back()
            : random.below(3) == 0
                ? affine(translation({std::round(p.x), std::round(p.y), std::round(p.z)}))
                : affine(random.transform(5)));
        array->prototype_of.push_back(static_cast<std::uint32_t>(random.below(3)));
        array->keys.push_back((array->keys.empty() ? -7 : array->keys.back()) + 1 +
                              static_cast<std::int64_t>(random.below(3)));
    }
    return array;
}

/// Instances of instances, three deep, with shapes of their own between.
inline ArrayPointer nested_array(Random& random) {
    ArrayPointer inner = random_array(random, 6);
    for (int depth = 0; depth < 2; ++depth) {
        auto outer = std::make_shared<InstanceArray>();
        outer->prototypes = {
            prototype({{"inner", inner, scaling(V3d(0.4)), ""},
                       {"box", std::shared_ptr<const Mesh>(box()), scaling(V3d(0.3)), "opaque"},
                       {"again", inner, scaling(V3d(0.3)) * translation({1, 0, 0}), ""}}),
            prototype({{"plane", quadric(QuadricKind::Plane), M44d(), "glass"}})};
        for (int i = 0; i < 4; ++i) {
            outer->array_from_prototype.push_back(affine(random.transform(3)));
            outer->prototype_of.push_back(i % 3 == 2 ? 1 : 0);
        }
        inner = outer;
    }
    return inner;
}

inline std::vector<std::uint32_t> all_slots(const Scene& scene) {
    std::vector<std::uint32_t> slots(scene.slot_count());
    for (std::uint32_t i = 0; i < slots.size(); ++i) slots[i] = i;
    return slots;
}

inline std::unique_ptr<trace::Intersector> intersector(const Scene& scene,
                                                       trace::TreeOptions options = {},
                                                       const std::string& isa = "avx2") {
    auto made = std::make_unique<trace::Intersector>(isa, 0, options);
    made->commit(scene, all_slots(scene));
    return made;
}

inline bool same_bits(double a, double b) { return __builtin_memcmp(&a, &b, sizeof a) == 0; }

inline bool same(const trace::Hit& a, const trace::Hit& b) {
    return same_bits(a.t, b.t) && same_bits(a.u, b.u) && same_bits(a.v, b.v) &&
           a.object == b.object && a.part == b.part && a.primitive == b.primitive &&
           a.piece == b.piece;
}

inline trace::Ray ray(const V3d& origin, const V3d& direction,
                      double t_max = std::numeric_limits<double>::infinity()) {
    return trace::make_ray(V3f(origin), V3f(direction), static_cast<float>(t_max));
}

}  // namespace irt::test
