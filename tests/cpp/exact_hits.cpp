// SPDX-License-Identifier: Apache-2.0
// `make exact-hits`: nearest hits and occlusion of trees that provably differ (another split, LOW
// quality, another instruction set), compared bit for bit over hostile and natural rays for every
// kind of primitive; a sample goes through the brute-force twin; closed surfaces must not leak.
// Usage: exact_hits [--rays N] [--leaks N]. Exit status 1 on any difference or leak.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>
#include <tuple>

#include "irt/trace/ray_origin.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;
using MeshPointer = std::shared_ptr<const Mesh>;

/// What rays are aimed at: vertices and edges in render space.
struct Targets {
    std::vector<V3d> points;
    std::vector<std::pair<V3d, V3d>> edges;
};

void add_targets(const Surface& surface, const M44d& render_from_trace, Targets& targets) {
    const auto at = [&](const V3d& p) { return transform_point(render_from_trace, p); };
    if (surface.triangles) {
        for (const auto& t : surface.triangles->triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const V3d a = at(V3d(surface.triangles->points[t[k]]));
                targets.points.push_back(a);
                targets.edges.emplace_back(a, at(V3d(surface.triangles->points[t[(k + 1) % 3]])));
            }
        return;
    }
    const auto out = [&](const V3d& p) { return at(transform_point(surface.trace_from_shape, p)); };
    if (surface.spheres || surface.curves) {
        // Poles and silhouettes of balls, and the circles where cones touch them.
        const auto& balls = surface.spheres ? surface.spheres->balls : surface.curves->balls;
        for (std::uint32_t k = 0; k < balls.size(); ++k) {
            const V3d centre(balls[k].centre);
            const auto r = static_cast<double>(balls[k].radius);
            for (int a = 0; a < 3; ++a)
                for (const double side : {-1.0, 1.0}) {
                    V3d pole = centre;
                    pole[a] += side * r;
                    targets.points.push_back(out(pole));
                    targets.edges.emplace_back(out(centre), out(pole));
                }
            const std::uint32_t next = surface.curves ? surface.curves->next_ball(k) : Curves::none;
            if (next == Curves::none) continue;
            const V3d end(balls[next].centre), along = end - centre;
            const auto end_radius = static_cast<double>(balls[next].radius);
            const double length = along.length(), sine = (r - end_radius) / length;
            if (!(std::fabs(sine) < 1)) continue;
            const double cosine = std::sqrt(1 - sine * sine);
            const V3d axis = along / length,
                      side = axis.cross(std::fabs(axis.x) < 0.5 ? V3d(1, 0, 0) : V3d(0, 1, 0))
                                 .normalized(),
                      other = axis.cross(side);
            for (int i = 0; i < 8; ++i) {
                const double angle = 3.14159265358979323846 * i / 4;
                const V3d normal =
                    (side * std::cos(angle) + other * std::sin(angle)) * cosine + axis * sine;
                targets.points.push_back(out(centre + normal * r));
                targets.points.push_back(out(end + normal * end_radius));
                targets.edges.emplace_back(out(centre + normal * r),
                                           out(end + normal * end_radius));
            }
        }
        return;
    }
    // Rims, poles, corners, apex: where one piece of a solid ends and the next begins.
    const Quadric& q = surface.quadric;
    const bool flat = q.kind == QuadricKind::Cube || q.kind == QuadricKind::Plane;
    const double x = q.kind == QuadricKind::Cube ? q.size / 2 : flat ? q.width / 2 : q.radius;
    const double y = q.kind == QuadricKind::Cube ? q.size / 2 : flat ? q.length / 2 : q.radius;
    const double z = q.kind == QuadricKind::Plane  ? 0
                     : q.kind == QuadricKind::Cube ? q.size / 2
                                                   : q.height / 2;
    for (int k = 0; k < 16; ++k) {
        const double angle = 3.14159265358979323846 * k / 8;
        const V3d rim = flat ? V3d(k & 1 ? x : -x, k & 2 ? y : -y, 0)
                             : V3d(x * std::cos(angle), y * std::sin(angle), 0);
        targets.points.push_back(out(rim + V3d(0, 0, z)));
        targets.points.push_back(out(rim - V3d(0, 0, z)));
        targets.edges.emplace_back(out(rim - V3d(0, 0, z)), out(rim + V3d(0, 0, z)));
        targets.edges.emplace_back(out(rim + V3d(0, 0, z)), out(V3d(0, 0, z)));
    }
    targets.points.push_back(out({0, 0, z}));
    targets.points.push_back(out({0, 0, -z}));
}

void add_targets(const CompiledPrototype& prototype, const M44d& render_from_prototype,
                 Targets& targets) {
    for (const Surface& part : prototype.surfaces)
        add_targets(part, render_from_prototype, targets);
    for (const NestedArray& array : prototype.arrays)
        for (std::size_t entry = 0; entry < array.record->size(); ++entry)
            add_targets(array.prototype(entry),
                        array.outer_from_prototype(entry) * render_from_prototype, targets);
}

struct Kind {
    std::string name;
    std::unique_ptr<Scene> scene;
    Targets targets;

    Kind(std::string called, const SceneBuilder& builder)
        : name(std::move(called)), scene(builder.scene()) {
        for (std::uint32_t slot = 0; slot < scene->slot_count(); ++slot)
            if (const CompiledPrototype* prototype = scene->prototype(slot))
                add_targets(*prototype, scene->render_from_prototype(slot), targets);
            else
                add_targets(scene->object(slot).surface, M44d(), targets);
    }
};

constexpr double reach = 8;  ///< scenes lie within this of the origin

/// Copies in the same place, in every material: ties, and sums of tints.
void add_copies(SceneBuilder& builder, const Geometry& geometry, Random& random, int count) {
    const char* const materials[] = {"opaque", "red glass", "glass"};
    for (int i = 0; i < count; ++i) {
        const V3d p = random.point() * 5;
        const M44d m = i % 3 == 0 ? translation({std::round(p.x), std::round(p.y), std::round(p.z)})
                                  : random.transform(5);
        for (std::size_t copy = 0; copy <= random.below(2); ++copy)
            builder.add(geometry, m, materials[random.below(3)]);
    }
}

std::vector<Kind> make_kinds() {
    std::vector<Kind> kinds;
    {
        SceneBuilder builder;
        builder.add(MeshPointer(board(64, 0.25)), M44d());
        const MeshPointer man = pawn(48, 48, 0.9);
        for (int i = 0; i < 32; ++i)
            builder.add(man,
                        translation({(i % 8) * 2.0 - 7, (i / 8) * 2.0 - (i / 8 < 2 ? 7 : -1), 0}),
                        i % 5 == 0 ? "red glass" : "opaque");
        kinds.emplace_back("triangles", builder);
    }
    {
        // Tiles that meet edge to edge, each an object of its own, some of them twice.
        SceneBuilder builder;
        const MeshPointer tile = board(4, 0.5);
        for (int i = 0; i < 64; ++i) {
            const M44d m = translation({(i % 8) * 2.0 - 7, (i / 8) * 2.0 - 7, 0});
            builder.add(tile, m, i % 3 == 0 ? "red glass" : "opaque");
            if (i % 7 == 0) builder.add(tile, m);
        }
        for (int i = 0; i < 4; ++i)
            builder.add(MeshPointer(box()),
                        scaling(V3d(0.5)) * translation({i * 1.0, i * 1.0, 0.5}));
        kinds.emplace_back("mesh seams", builder);
    }
    Random random(11);
    for (const auto& [kind, name] : quadric_kinds()) {
        SceneBuilder builder;
        add_copies(builder, quadric(kind), random, 40);
        kinds.emplace_back(name, builder);
    }
    {
        // Each cloud and tuft in several places and, in places, twice.
        SceneBuilder builder;
        for (int i = 0; i < 4; ++i)
            add_copies(builder, std::shared_ptr<const Spheres>(cloud(random, 40)), random, 4);
        kinds.emplace_back("spheres", builder);
    }
    for (const auto& [name, balls, radius] :
         {std::tuple{"curves", 6u, 0.15}, {"thin curves", 6u, 1e-6}, {"thick curves", 40u, 0.4}}) {
        SceneBuilder builder;
        for (int i = 0; i < 4; ++i)
            add_copies(builder,
                       std::shared_ptr<const Curves>(strands(random, 4, balls, i % 2 == 0, radius)),
                       random, balls > 6 ? 2 : 4);
        kinds.emplace_back(name, builder);
    }
    {
        SceneBuilder builder;
        for (int i = 0; i < 8; ++i) add_copies(builder, bands(random, 3, i % 2 == 0), random, 3);
        kinds.emplace_back("ribbons", builder);
    }
    {
        SceneBuilder builder;
        auto prototype = std::make_shared<Prototype>();
        prototype->parts = {
            {"curves", std::shared_ptr<const Curves>(strands(random, 2, 5, true)),
             translation({0, -2, 0}), "red glass"},
            {"spheres", std::shared_ptr<const Spheres>(cloud(random, 8)), translation({-2, 0, 0}),
             "glass"},
            {"mesh", MeshPointer(ball(16, 24)), M44d(), "opaque"},
            {"box", MeshPointer(box()), translation({0, 0, 1.5}), "glass"},
            {"cone", quadric(QuadricKind::Cone), translation({0, 2, 0}), "red glass"}};
        add_copies(builder, std::shared_ptr<const Prototype>(prototype), random, 40);
        kinds.emplace_back("instances", builder);
    }
    {
        // Tiles that meet edge to edge, some of them twice, and solids in every place and size.
        SceneBuilder builder;
        builder.add(tile_array(), M44d());
        builder.add(random_array(random, 60), M44d());
        builder.add(random_array(random, 20), random.transform(2));
        kinds.emplace_back("arrays", builder);
    }
    {
        SceneBuilder builder;
        builder.add(nested_array(random), M44d());
        builder.add(nested_array(random), random.transform(2));
        kinds.emplace_back("nested arrays", builder);
    }
    {
        SceneBuilder builder;
        for (const auto& [kind, name] : quadric_kinds())
            add_copies(builder, quadric(kind), random, 6);
        add_copies(builder, MeshPointer(ball(16, 24)), random, 6);
        add_copies(builder, MeshPointer(box()), random, 6);
        add_copies(builder, std::shared_ptr<const Spheres>(cloud(random, 8)), random, 6);
        add_copies(builder, std::shared_ptr<const Curves>(strands(random, 2, 5, false)), random, 6);
        add_copies(builder, bands(random, 2, true), random, 6);
        kinds.emplace_back("mixed", builder);
    }
    return kinds;
}

/// Makes the i-th of n rays of a family; may ask for nearest hits to start from.
using Family = std::function<trace::Ray(const Kind&, const trace::Intersector&, Random&,
                                        std::size_t i, std::size_t n)>;

trace::Ray camera_ray(std::size_t i, std::size_t n) {
    const auto width = static_cast<std::size_t>(std::sqrt(static_cast<double>(n))) | 1;
    const double w = static_cast<double>(width), x = static_cast<double>(i % width),
                 y = static_cast<double>(i / width % width);
    return ray({0, -14, 7}, V3d((x - (w - 1) / 2) / w, 1, -0.5 - (y - (w - 1) / 2) / w));
}

V3d somewhere(Random& random) { return random.point() * reach; }

/// A ray that leaves the surface a camera ray hits, along what `turn` makes of its point.
template <class Turn>
trace::Ray leaving(const Kind& kind, const trace::Intersector& trees, Random& random, std::size_t i,
                   std::size_t n, Turn&& turn) {
    trace::QueryCounts counts;
    const trace::Ray first = camera_ray(i, n);
    const trace::Hit hit = trees.nearest(first, counts);
    if (!hit) return ray(somewhere(random), random.direction());
    const trace::SurfacePoint point = surface_point(*kind.scene, first, hit);
    double t_max = std::numeric_limits<double>::infinity();
    const V3d direction = turn(first, point, t_max);
    return ray(V3d(offset_ray_origin(point, direction)), direction, t_max);
}

const std::vector<std::pair<const char*, Family>>& families() {
    static const std::vector<std::pair<const char*, Family>> all{
        {"perspective, centred", [](const Kind&, const trace::Intersector&, Random&, std::size_t i,
                                    std::size_t n) { return camera_ray(i, n); }},
        {"orthographic, dyadic",
         [](const Kind&, const trace::Intersector&, Random&, std::size_t i, std::size_t) {
             const double x = static_cast<double>(i % 512), y = static_cast<double>(i / 512 % 512);
             return ray({(x - 256) / 32, (y - 256) / 32, 10}, {0, 0, -1});
         }},
        {"aimed at vertices",
         [](const Kind& kind, const trace::Intersector&, Random& random, std::size_t, std::size_t) {
             const V3d p = kind.targets.points[random.below(kind.targets.points.size())];
             const V3d o = V3d(V3f(somewhere(random)));
             return ray(o, p - o);
         }},
        {"aimed at edges",
         [](const Kind& kind, const trace::Intersector&, Random& random, std::size_t, std::size_t) {
             const auto& [a, b] = kind.targets.edges[random.below(kind.targets.edges.size())];
             const double w = 0.5 + 0.5 * random();
             const V3d o = V3d(V3f(somewhere(random) * (random() < 0 ? 1 : 100)));
             return ray(o, a * w + b * (1 - w) - o);
         }},
        {"axis-parallel, vertices",
         [](const Kind& kind, const trace::Intersector&, Random& random, std::size_t, std::size_t) {
             V3d o = kind.targets.points[random.below(kind.targets.points.size())], d(0, 0, 0);
             const int axis = static_cast<int>(random.below(3));
             d[axis] = random() < 0 ? -1 : 1;
             o[axis] -= 20 * d[axis];
             return ray(o, d);
         }},
        {"random",
         [](const Kind&, const trace::Intersector&, Random& random, std::size_t, std::size_t) {
             const V3d o = somewhere(random);
             return ray(o, random.direction());
         }},
        {"shadow, distant and point",
         [](const Kind& kind, const trace::Intersector& trees, Random& random, std::size_t i,
            std::size_t n) {
             return leaving(kind, trees, random, i, n,
                            [&](const trace::Ray&, const trace::SurfacePoint& p, double& t_max) {
                                if (i % 3 == 0) return V3d(0, 0, 1);
                                if (i % 3 == 1) return V3d(0.5, 0.25, 1);
                                t_max = 1;
                                return V3d(3, -2, 6) - p.position;
                            });
         }},
        {"mirror",
         [](const Kind& kind, const trace::Intersector& trees, Random& random, std::size_t i,
            std::size_t n) {
             return leaving(kind, trees, random, i, n,
                            [](const trace::Ray& r, const trace::SurfacePoint& p, double&) {
                                const V3d d(r.direction);
                                return d - p.geometric_normal * (2 * d.dot(p.geometric_normal));
                            });
         }},
    };
    return all;
}

/// Runs work(seed, count) on every processor until `count` rays are spent.
template <class Work>
void in_parallel(std::size_t count, Work&& work) {
    constexpr std::size_t block = 4096;
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
        for (std::size_t first; (first = next.fetch_add(block)) < count;)
            work(first, std::min(count, first + block));
    };
    std::vector<std::thread> threads(std::max(1u, std::thread::hardware_concurrency()));
    for (std::thread& thread : threads) thread = std::thread(run);
    for (std::thread& thread : threads) thread.join();
}

struct Tally {
    std::size_t rays = 0, differences = 0, leaks = 0, twins = 0;
};

void print_row(const char* kind, const char* family, const Tally& row) {
    std::printf("| %-13s | %-26s | %11zu | %11zu | %7zu | %8zu |\n", kind, family, row.rays,
                row.differences, row.leaks, row.twins);
    std::fflush(stdout);
}

bool same_dark(const trace::Occlusion& a, const trace::Occlusion& b) { return a.depth == b.depth; }

/// Rays that also go through the brute-force twin, a row.
constexpr std::size_t twins_a_row = 200;

Tally compare(const Kind& kind, const Family& family, std::size_t rays) {
    const Scene& scene = *kind.scene;
    static const std::string other = trace::best_isa() == "avx512" ? "avx512" : "sse2";
    const auto reference = intersector(scene);
    const std::unique_ptr<trace::Intersector> others[] = {intersector(scene, {true, 0}),
                                                          intersector(scene, {false, 1}),
                                                          intersector(scene, {true, 7}, other)};
    std::atomic<std::size_t> differences{0}, twins{0};
    const std::size_t stride = std::max<std::size_t>(1, rays / twins_a_row);
    in_parallel(rays, [&](std::size_t first, std::size_t last) {
        Random random(first + 1);
        trace::QueryCounts counts;
        for (std::size_t i = first; i < last; ++i) {
            const trace::Ray r = family(kind, *reference, random, i, rays);
            const trace::Hit hit = reference->nearest(r, counts);
            const trace::Occlusion dark = reference->occlusion(r, counts);
            bool alike = true;
            for (const auto& tree : others)
                alike = alike && same(hit, tree->nearest(r, counts)) &&
                        same_dark(dark, tree->occlusion(r, counts));
            if (i % stride == 0) {
                ++twins;
                alike = alike && same(hit, brute_force_nearest(scene, r)) &&
                        same_dark(dark, brute_force_occlusion(scene, r));
            }
            if (!alike) ++differences;
        }
    });
    return {rays, differences, 0, twins};
}

/// A closed surface about the origin of radius 1 to 2, and how far away rays start.
struct Closed {
    const char* name;
    const char* family;
    SceneBuilder builder;
    double from;  ///< below 1: inside
};

SceneBuilder one(const Geometry& geometry, const M44d& world_from_object) {
    SceneBuilder builder;
    builder.add(geometry, world_from_object);
    return builder;
}

std::vector<Closed> make_closed() {
    const MeshPointer coarse = ball(64, 64), fine = ball(400, 400);
    const M44d turned = rotation(0, 0.3) * rotation(1, 0.2);
    auto prototype = std::make_shared<Prototype>();
    prototype->parts.push_back({"ball", coarse, scaling(V3d(3)) * rotation(2, 1), "opaque"});
    const std::shared_ptr<const Prototype> shared = prototype;
    const M44d shrunk = scaling(V3d(1.0 / 3)) * turned;

    // A cube whose six faces are objects of their own: seams between meshes, and between instances.
    SceneBuilder faces;
    auto entries = std::make_shared<InstanceArray>();
    const MeshPointer face = board(16, 0.125);
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            M44d m = translation({0, 0, side});
            M44d cycle;
            cycle.makeIdentity();
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) cycle[a][b] = b == (a + axis) % 3 ? 1 : 0;
            faces.add(face, m * cycle);
            entries->array_from_prototype.push_back(affine(m * cycle));
        }
    entries->prototypes = {test::prototype({{"face", face, M44d(), "opaque"}})};
    auto outer = std::make_shared<InstanceArray>();
    outer->prototypes = {test::prototype({{"faces", ArrayPointer(entries), M44d(), ""}})};
    outer->array_from_prototype = {affine(M44d())};
    return {{"8k ball", "edges, from inside", one(coarse, turned), 0.3},
            {"ribbon", "edges, from inside", one(drum(500), turned), 0.3},
            {"ribbon", "edges, from 10 radii", one(drum(500), turned), 10},
            {"320k ball", "edges, from inside", one(fine, turned), 0.3},
            {"320k ball", "edges, from 10 radii", one(fine, turned), 10},
            {"320k ball", "edges, from 100 radii", one(fine, turned), 100},
            {"mesh seams", "edges, from inside", faces, 0.3},
            {"mesh seams", "edges, from 10 radii", faces, 10},
            {"instance", "edges, from inside", one(shared, shrunk), 0.3},
            {"instance", "edges, from 10 radii", one(shared, shrunk), 10},
            {"array seams", "edges, from inside", one(ArrayPointer(entries), M44d()), 0.3},
            {"array seams", "edges, from 10 radii", one(ArrayPointer(outer), M44d()), 10}};
}

/// A ray leaks that finds no wall, or, coming from outside, whose first wall lies beyond the
/// centre.
Tally leak(const Closed& closed, std::size_t rays) {
    const Kind kind(closed.name, closed.builder);
    const auto trees = intersector(*kind.scene);
    std::atomic<std::size_t> leaks{0};
    const bool outside = closed.from > 1;
    in_parallel(rays, [&](std::size_t first, std::size_t last) {
        Random random(first + 1);
        trace::QueryCounts counts;
        for (std::size_t i = first; i < last; ++i) {
            V3d o, target;
            do {
                o = V3d(V3f(random.direction() * closed.from));
                const auto& [a, b] = kind.targets.edges[random.below(kind.targets.edges.size())];
                const double w = i % 4 == 0 ? 1 : 0.5 + 0.5 * random();
                target = a * w + b * (1 - w);
                // From outside, past the silhouette: towards the near wall or the far one.
            } while (outside && (target - o).cross(o).length() > 0.9 * (target - o).length());
            const trace::Ray r = ray(o, target - o);
            const trace::Hit hit = trees->nearest(r, counts);
            const bool in_front =
                hit && (!outside || (V3d(r.origin) + V3d(r.direction) * hit.t).dot(o) > 0);
            if (!in_front) ++leaks;
        }
    });
    return {rays, 0, leaks, 0};
}

/// Rays from inside a curve that find no wall, and rays aimed into one from outside that get there.
Tally curve_leak(const char* name, double radius, std::uint32_t balls, std::size_t rays) {
    Random setting(3);
    const auto curves = strands(setting, 8, balls, true, radius);
    const Kind kind(name, one(std::shared_ptr<const Curves>(curves), rotation(0, 0.3)));
    const auto trees = intersector(*kind.scene);
    std::atomic<std::size_t> leaks{0}, shot{0};
    in_parallel(rays, [&](std::size_t first, std::size_t last) {
        Random random(first + 1);
        trace::QueryCounts counts;
        for (std::size_t i = first; i < last; ++i) {
            const Ball& ball = curves->balls[random.below(curves->balls.size())];
            const V3d in_shape =
                V3d(ball.centre) + random.direction() * (0.9 * static_cast<double>(ball.radius));
            const V3d inside = V3d(V3f(transform_point(rotation(0, 0.3), in_shape)));
            // Narrowing must not take the origin out of a thin curve.
            const V3d back = transform_point(rotation(0, -0.3), inside);
            if ((back - V3d(ball.centre)).length() > 0.95 * static_cast<double>(ball.radius))
                continue;
            ++shot;
            const V3d target = kind.targets.points[random.below(kind.targets.points.size())];
            if (!trees->nearest(ray(inside, i % 2 == 0 ? random.direction() : target - inside),
                                counts))
                ++leaks;
            const V3d from = V3d(V3f(inside + random.direction() * (i % 3 == 0 ? 100.0 : 3.0)));
            const trace::Hit seen = trees->nearest(ray(from, inside - from), counts);
            const bool exact = static_cast<double>(ball.radius) > 1e-4;  // else the aim is not
            if (exact && !(seen && seen.t < 1)) ++leaks;
        }
    });
    return {shot, 0, leaks, 0};
}

std::size_t number(const char* text) {
    char* end = nullptr;
    const double value = std::strtod(text, &end);
    if (end == text || *end != 0 || !(value >= 0 && value < 1e15)) {
        std::fprintf(stderr, "exact_hits: '%s' is not a number of rays\n", text);
        std::exit(2);
    }
    return static_cast<std::size_t>(value);
}

int run(int argc, char** argv) {
    std::size_t rays = 10'000'000, leak_rays = 2'000'000;
    for (int i = 1; i < argc; ++i) {
        if (i + 1 < argc && std::strcmp(argv[i], "--rays") == 0)
            rays = number(argv[++i]);
        else if (i + 1 < argc && std::strcmp(argv[i], "--leaks") == 0)
            leak_rays = number(argv[++i]);
        else {
            std::fprintf(stderr, "usage: exact_hits [--rays N] [--leaks N]\n");
            return 2;
        }
    }
    std::printf(
        "| kind         | rays                       | rays        | differences | leaks   | "
        "by twin  |\n| --- | --- | ---: | ---: | ---: | ---: |\n");
    Tally total;
    const auto count = [&](const char* kind, const char* family, const Tally& row) {
        print_row(kind, family, row);
        total.rays += row.rays;
        total.differences += row.differences;
        total.leaks += row.leaks;
        total.twins += row.twins;
    };
    const std::vector<Kind> kinds = make_kinds();
    const std::size_t a_row =
        (rays + kinds.size() * families().size() - 1) / (kinds.size() * families().size());
    for (const Kind& kind : kinds)
        for (const auto& [name, family] : families())
            count(kind.name.c_str(), name, compare(kind, family, a_row));
    const std::vector<Closed> closed = make_closed();
    for (const Closed& c : closed)
        count(c.name, c.family, leak(c, (leak_rays + closed.size() - 1) / closed.size()));
    const std::size_t curve_rays = leak_rays / 8;
    count("curves", "from inside and outside", curve_leak("curves", 0.15, 6, curve_rays));
    count("thick curves", "from inside and outside", curve_leak("thick", 0.3, 24, curve_rays));
    count("thin curves", "from inside and outside", curve_leak("thin", 1e-4, 6, curve_rays));
    count("total", "", total);
    return total.differences == 0 && total.leaks == 0 ? 0 : 1;
}

}  // namespace
}  // namespace irt

int main(int argc, char** argv) { return irt::run(argc, argv); }
