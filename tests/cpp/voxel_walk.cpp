// SPDX-License-Identifier: Apache-2.0
// The paper's passing-voxel history against the key of first and last voxel that stands for it here
// (irt/history/voxel_grid.h), once each: entries, bytes, time to make, and what of the rays an edit
// flags. Prints the table of docs/measurements.md, "Ablation".
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <unordered_map>
#include <vector>

#include "irt/history/path_table.h"
#include "irt/update/footprint.h"
#include "irt/view.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;
using VoxelIndex = std::uint32_t;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A grid of any fineness over a box.
struct Grid {
    trace::Box box;
    int side;

    [[nodiscard]] V3d in_voxels(const V3d& p) const {
        return (p - box.lower) / (box.upper - box.lower) * side;
    }
    [[nodiscard]] VoxelIndex index(const std::array<int, 3>& v) const {
        return static_cast<VoxelIndex>((v[2] * side + v[1]) * side + v[0]);
    }
};

/// The voxels of `grid` along a ray up to `t_end`, sorted (Amanatides and Woo, "A Fast Voxel
/// Traversal Algorithm for Ray Tracing", Eurographics 1987).
void walk(const Grid& grid, const trace::Ray& ray, double t_end, std::vector<VoxelIndex>& set) {
    set.clear();
    double enter = 0, exit = t_end;
    const V3d origin(ray.origin), direction(ray.direction);
    if (!trace::clip(grid.box, origin, direction, enter, exit)) return;
    const V3d from = grid.in_voxels(origin + direction * enter),
              to = grid.in_voxels(origin + direction * exit), along = to - from;
    std::array<int, 3> voxel{}, last{}, step{};
    V3d next, per_voxel;
    int steps = 0;
    for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        voxel[axis] = std::clamp(static_cast<int>(from[a]), 0, grid.side - 1);
        last[axis] = std::clamp(static_cast<int>(to[a]), 0, grid.side - 1);
        step[axis] = along[a] < 0 ? -1 : 1;
        steps += std::abs(last[axis] - voxel[axis]);
        per_voxel[a] = std::fabs(1 / along[a]);
        next[a] = ((along[a] < 0 ? voxel[axis] : voxel[axis] + 1) - from[a]) / along[a];
    }
    set.push_back(grid.index(voxel));
    for (; steps > 0; --steps) {
        int a = -1;
        for (int b = 0; b < 3; ++b) {
            const auto axis = static_cast<std::size_t>(b);
            if (voxel[axis] != last[axis] && (a < 0 || next[b] < next[a])) a = b;
        }
        voxel[static_cast<std::size_t>(a)] += step[static_cast<std::size_t>(a)];
        next[a] += per_voxel[a];
        set.push_back(grid.index(voxel));
    }
    std::sort(set.begin(), set.end());
}

/// Rays of a picture, with where they end, and those that an edit truly changes.
struct Rays {
    std::vector<trace::Ray> rays;
    std::vector<double> ends;
    std::vector<bool> changed;
};

/// Chessmen of spheres, cones and cylinders on a board, 128 quadrics.
SceneBuilder chess() {
    SceneBuilder builder;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j)
            builder.add(
                quadric(QuadricKind::Cube),
                scaling({2.5, 2.5, 0.25}) * translation({5.0 * i - 17.5, 5.0 * j - 17.5, -0.25}));
    for (int i = 0; i < 16; ++i) {
        const V3d at(5.0 * (i % 8) - 17.5, i < 8 ? -12.5 : 12.5, 0);
        builder.add(quadric(QuadricKind::Cylinder),
                    scaling({1.5, 1.5, 0.5}) * translation(at + V3d(0, 0, 0.5)));
        builder.add(quadric(QuadricKind::Cone),
                    scaling({1.2, 1.2, 2}) * translation(at + V3d(0, 0, 3)));
        builder.add(quadric(QuadricKind::Sphere),
                    scaling(V3d(0.9)) * translation(at + V3d(0, 0, 5)));
        builder.add(quadric(QuadricKind::Sphere),
                    scaling({1.4, 1.4, 0.4}) * translation(at + V3d(0, 0, 1)));
    }
    return builder;
}

Rays record(const Scene& scene, const trace::Intersector& found, std::uint32_t edited) {
    Camera camera;
    camera.world_from_camera = rotation(0, 0.9) * translation({0, -36, 30});
    camera.window = {-0.6, 0.6, -0.45, 0.45};
    ViewSettings settings;
    settings.width = 512;
    settings.height = 384;
    const View view(camera, settings, V3d(0));
    shade::RayRecord recorded;
    (void)view.record(scene, found, recorded);
    Rays out;
    trace::QueryCounts counts;
    const auto add = [&](const trace::Ray& ray, double end) {
        out.rays.push_back(ray);
        out.ends.push_back(end);
        const trace::JudgeRay judged = trace::judge_ray(ray);
        trace::Hit hit;
        out.changed.push_back(
            trace::judge_primitive(scene.all_objects()[edited].surface, 0, judged, hit) &&
            hit.t <= end);
    };
    for (const trace::Ray& ray : recorded.nearest) add(ray, found.nearest(ray, counts).t);
    for (const trace::Ray& ray : recorded.occlusion) add(ray, static_cast<double>(ray.t_max));
    return out;
}

void report(const char* name, int side, std::size_t entries, std::size_t bytes, double make,
            double scan, std::size_t flagged, const Rays& rays) {
    const auto changed =
        static_cast<std::size_t>(std::count(rays.changed.begin(), rays.changed.end(), true));
    std::printf("| %s | %d | %zu | %.1f | %.0f | %.2f | %zu | %.1f |\n", name, side, entries,
                static_cast<double>(bytes) / (1 << 20),
                1e9 * make / static_cast<double>(rays.rays.size()), 1e3 * scan, flagged,
                static_cast<double>(flagged) / static_cast<double>(changed));
}

/// The paper's: each distinct set once, flagged where it holds a changed voxel.
void sets_of_voxels(int side, const trace::Box& box, const trace::Box& edited_box,
                    const Rays& rays) {
    const Grid grid{box, side};
    const auto start = std::chrono::steady_clock::now();
    std::unordered_map<std::string, std::uint32_t> table;
    std::vector<std::vector<VoxelIndex>> sets;
    std::vector<std::uint32_t> entry_of(rays.rays.size());
    std::vector<VoxelIndex> set;
    for (std::size_t i = 0; i < rays.rays.size(); ++i) {
        walk(grid, rays.rays[i], rays.ends[i], set);
        const std::string key(reinterpret_cast<const char*>(set.data()),
                              set.size() * sizeof set[0]);
        const auto [entry, added] = table.try_emplace(key, static_cast<std::uint32_t>(sets.size()));
        if (added) sets.push_back(set);
        entry_of[i] = entry->second;
    }
    const double make = seconds_since(start);
    std::vector<bool> voxels(static_cast<std::size_t>(side * side * side));
    const V3d lower = grid.in_voxels(edited_box.lower), upper = grid.in_voxels(edited_box.upper);
    const auto clamped = [&](double v) { return std::clamp(static_cast<int>(v), 0, side - 1); };
    for (int z = clamped(lower.z); z <= clamped(upper.z); ++z)
        for (int y = clamped(lower.y); y <= clamped(upper.y); ++y)
            for (int x = clamped(lower.x); x <= clamped(upper.x); ++x)
                voxels[grid.index({x, y, z})] = true;
    const auto scanned = std::chrono::steady_clock::now();
    std::vector<bool> flags(sets.size());
    std::size_t bytes = 0;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        flags[s] = std::any_of(sets[s].begin(), sets[s].end(),
                               [&](VoxelIndex voxel) { return voxels[voxel]; });
        bytes += sets[s].size() * sizeof(VoxelIndex) + sizeof(std::uint32_t);
    }
    const double scan = seconds_since(scanned);
    std::size_t flagged = 0;
    for (const std::uint32_t entry : entry_of) flagged += flags[entry];
    report("set of voxels", side, sets.size(), bytes, make, scan, flagged, rays);
}

/// Ours.
void keys_of_hulls(const trace::Box& crowd, const Scene& scene, std::uint32_t edited,
                   const Rays& rays) {
    history::PathTable table;
    table.reset(history::VoxelGrid(crowd), rays.rays.size() / 8, false);
    const auto start = std::chrono::steady_clock::now();
    std::vector<history::PathIndex> entry_of(rays.rays.size());
    for (std::size_t i = 0; i < rays.rays.size(); ++i)
        entry_of[i] = table.intern(
            table.grid().path(rays.rays[i].origin, rays.rays[i].direction, rays.ends[i]));
    const double make = seconds_since(start);
    update::Footprints footprint(table.grid(), 1);
    footprint.add(scene, edited);
    const history::Regions regions = footprint.regions();
    const auto scanned = std::chrono::steady_clock::now();
    table.clear_flags();
    table.flag(regions, 0, table.capacity());
    const double scan = seconds_since(scanned);
    std::size_t flagged = 0;
    for (const history::PathIndex entry : entry_of) flagged += table.flagged(entry);
    report("first and last voxel", static_cast<int>(history::grid_side), table.entries(),
           table.bytes(), make, scan, flagged, rays);
}

}  // namespace
}  // namespace irt

int main() {
    using namespace irt;
    ChangeSet changes = chess().changes();
    changes.materials["opaque"]->roughness = 0.05f;
    changes.lights["/lamp"] = Light{LightKind::Point, V3d(0, 0, -1), V3d(-30, 20, 55)};
    const auto scene = std::make_unique<Scene>(V3d(0, 0, 0));
    scene->apply(changes);
    const auto found = test::intersector(*scene);
    std::uint32_t edited = 0;  // the head of a man in front
    for (std::uint32_t slot = 0; slot < scene->slot_count(); ++slot)
        if (scene->all_objects()[slot].path == "/o78") edited = slot;
    const Rays rays = record(*scene, *found, edited);
    std::vector<trace::Box> boxes;
    trace::Box all;
    for (std::uint32_t slot = 0; slot < scene->slot_count(); ++slot) {
        boxes.push_back(found->box(slot));
        all.extend(found->box(slot));
    }
    std::printf("%zu rays, of which %td meet the edited object\n\n", rays.rays.size(),
                std::count(rays.changed.begin(), rays.changed.end(), true));
    std::printf(
        "| path | side | entries | MB | ns a ray | ms a scan | flagged | flagged over met |\n");
    std::printf("| --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (const int side : {8, 16, 32, 64, 128}) sets_of_voxels(side, all, found->box(edited), rays);
    keys_of_hulls(history::crowded_box(boxes), *scene, edited, rays);
}
