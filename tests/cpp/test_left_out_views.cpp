// SPDX-License-Identifier: Apache-2.0
// Views that an update leaves out, and what they show when they are asked for again.
#include <gtest/gtest.h>

#include <algorithm>

#include "irt/renderer.h"
#include "trace_scenes.h"

namespace irt {
namespace {

using namespace test;

constexpr int width = 48, height = 32;

Camera camera_at(double x) {
    Camera camera;
    camera.world_from_camera = translation({x, 0, 12});
    return camera;
}

ViewSettings settings() {
    ViewSettings s;
    s.width = width;
    s.height = height;
    return s;
}

ChangeSet scene() {
    SceneBuilder builder;
    for (int i = 0; i < 6; ++i)
        builder.add(Quadric{}, translation({2.0 * i - 5, 0.4 * i - 1, 0.3 * i}));
    ChangeSet changes = builder.changes();
    changes.lights["/sun"] = Light{};
    return changes;
}

ChangeSet moved(int ball, double y) {
    SceneBuilder builder;
    builder.add(Quadric{}, translation({2.0 * ball - 5, y, 0}));
    ChangeSet changes;
    changes.objects["/o" + std::to_string(ball)] = builder.changes().objects.begin()->second;
    return changes;
}

/// Updates stay updates, however small the scene is.
RendererOptions options() {
    RendererOptions o;
    o.cost_model = false;
    return o;
}

std::vector<float> film(const Renderer& renderer, std::size_t view) {
    const float* rgba = renderer.film(view).beauty();
    return {rgba, rgba + 4 * width * height};
}

/// The film of a renderer that is told everything at once.
std::vector<float> fresh(const std::vector<ChangeSet>& edits, const Camera& camera) {
    ChangeSet all = scene();
    for (const ChangeSet& edit : edits)
        for (const auto& [name, object] : edit.objects) all.objects[name] = object;
    Renderer renderer(camera, settings(), options());
    cells::Control control;
    renderer.update(all, {{}}, control);
    return film(renderer, 0);
}

ViewUpdate left_out() {
    ViewUpdate update;
    update.wanted = false;
    return update;
}

TEST(LeftOutViews, CatchUpWithOneUpdateAndAreTracedAnewAfterTwo) {
    Renderer renderer(camera_at(0), settings(), options());
    renderer.add_view(camera_at(2), settings());
    cells::Control control;
    renderer.update(scene(), {{}, {}}, control);
    const std::vector<float> before = film(renderer, 1);

    const std::vector<ChangeSet> edits{moved(1, 2), moved(2, -2), moved(3, 1)};
    renderer.update(edits[0], {{}, left_out()}, control);
    EXPECT_EQ(film(renderer, 0), fresh({edits[0]}, camera_at(0)));
    EXPECT_EQ(film(renderer, 1), before);
    EXPECT_TRUE(renderer.catches_up(1));
    const auto caught_up = renderer.update({}, {{}, {}}, control);
    EXPECT_TRUE(caught_up[1].traced);
    EXPECT_EQ(caught_up[1].restart, "");
    EXPECT_EQ(film(renderer, 1), fresh({edits[0]}, camera_at(2)));

    renderer.update(edits[1], {{}, left_out()}, control);
    renderer.update(edits[2], {{}, left_out()}, control);
    EXPECT_FALSE(renderer.catches_up(1));
    const auto late = renderer.update({}, {{}, {}}, control);
    EXPECT_NE(late[1].restart, "");
    EXPECT_EQ(film(renderer, 1), fresh(edits, camera_at(2)));
    renderer.validate();
}

TEST(LeftOutViews, AreGivenUpWithTheirCamera) {
    Renderer renderer(camera_at(0), settings(), options());
    renderer.add_view(camera_at(2), settings());
    cells::Control control;
    renderer.update(scene(), {{}, {}}, control);
    const ChangeSet edit = moved(1, 2);
    renderer.update(edit, {{}, left_out()}, control);
    ViewUpdate elsewhere;
    elsewhere.camera = camera_at(1);
    renderer.update({}, {{}, elsewhere}, control);
    EXPECT_EQ(film(renderer, 1), fresh({edit}, camera_at(1)));
    renderer.remove_view(0);
    EXPECT_EQ(renderer.view_count(), 1u);
    renderer.release_history(0);
    const ChangeSet other = moved(4, 1);
    renderer.update(other, {{}}, control);
    EXPECT_EQ(film(renderer, 0), fresh({edit, other}, camera_at(1)));
}

}  // namespace
}  // namespace irt
