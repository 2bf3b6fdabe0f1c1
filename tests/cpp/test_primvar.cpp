// SPDX-License-Identifier: Apache-2.0
// Primvars: what is refused, what counts as a change, and values at hits.
#include <gtest/gtest.h>

#include <stdexcept>

#include "irt/scene/compile.h"
#include "irt/scene/primvar.h"

namespace irt {
namespace {

/// Two squares side by side on 6 points.
std::shared_ptr<Mesh> two_squares() {
    auto mesh = std::make_shared<Mesh>();
    mesh->points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    mesh->face_vertex_counts = {4, 4};
    mesh->face_vertex_indices = {0, 1, 4, 3, 1, 2, 5, 4};
    return mesh;
}

/// A primvar of two floats: element, and ten times as much.
Primvar pairs(Interpolation interpolation, int count) {
    Primvar primvar{"st", interpolation, 2, {}, {}};
    for (int i = 0; i < count; ++i) {
        primvar.values.push_back(static_cast<float>(i));
        primvar.values.push_back(static_cast<float>(10 * i));
    }
    return primvar;
}

std::shared_ptr<const Triangles> with(const Primvar& primvar) {
    const auto mesh = two_squares();
    mesh->primvars = {primvar};
    return triangulate(mesh, M44d(), "/mesh");
}

TEST(Primvar, ValuesByInterpolation) {
    // The third triangle is corners 4, 5, 6: points 1, 2, 5 of face 1.
    const auto at = [](const Primvar& primvar, double u, double v) {
        const auto triangles = with(primvar);
        return primvar_at(*triangles, triangles->mesh->primvars[0], 2, u, v);
    };
    EXPECT_EQ(at(pairs(Interpolation::Constant, 1), 0.3, 0.4), (PrimvarValue{0, 0, 0, 0}));
    EXPECT_EQ(at(pairs(Interpolation::Uniform, 2), 0.3, 0.4), (PrimvarValue{1, 10, 0, 0}));
    EXPECT_EQ(at(pairs(Interpolation::Vertex, 6), 0.5, 0.25), (PrimvarValue{2.5, 25, 0, 0}));
    EXPECT_EQ(at(pairs(Interpolation::FaceVarying, 8), 0, 1), (PrimvarValue{6, 60, 0, 0}));
    Primvar indexed = pairs(Interpolation::FaceVarying, 2);
    indexed.indices = {0, 0, 0, 0, 1, 0, 1, 0};
    EXPECT_EQ(at(indexed, 0.5, 0), (PrimvarValue{0.5, 5, 0, 0}));
}

TEST(Primvar, WrongSizesAreNamed) {
    const auto refusal = [](const Primvar& primvar) -> std::string {
        try {
            with(primvar);
        } catch (const std::invalid_argument& fault) {
            return fault.what();
        }
        return "";
    };
    EXPECT_EQ(refusal(pairs(Interpolation::Vertex, 5)),
              "/mesh: primvar st has 5 elements, expected 6");
    Primvar indexed = pairs(Interpolation::Uniform, 1);
    indexed.indices = {0, 1};
    EXPECT_EQ(refusal(indexed), "/mesh: primvar st has index 1, but 1 values");
    Primvar cut = pairs(Interpolation::Constant, 1);
    cut.values.pop_back();
    EXPECT_EQ(refusal(cut), "/mesh: primvar st ends within a value of 2 floats");
}

TEST(Primvar, FoundByName) {
    const Primvars primvars{{"a", Interpolation::Constant, 1, {1}, {}},
                            {"st", Interpolation::Constant, 1, {2}, {}}};
    EXPECT_EQ(find_primvar(primvars, "st"), &primvars[1]);
    EXPECT_EQ(find_primvar(primvars, "b"), nullptr);
    EXPECT_EQ(constant_value(primvars[1]), (PrimvarValue{2, 0, 0, 0}));
}

TEST(Primvar, EveryBitIsAChange) {
    Scene scene({0, 0, 0});
    ChangeSet changes;
    changes.materials["/m"] = Material{};
    const auto apply = [&](const Primvars& of_mesh, const Primvars& of_object) {
        const auto mesh = two_squares();
        mesh->primvars = of_mesh;
        changes.objects["/mesh"] =
            Object{std::shared_ptr<const Mesh>(mesh), M44d(), "/m", of_object};
        return !scene.apply(changes).empty();
    };
    Primvar st = pairs(Interpolation::Vertex, 6), color = pairs(Interpolation::Constant, 1);
    color.name = "color";
    EXPECT_TRUE(apply({st}, {color}));
    EXPECT_FALSE(apply({st}, {color}));
    st.values[0] = -0.0f;
    EXPECT_TRUE(apply({st}, {color}));
    color.values[1] = 1;
    EXPECT_TRUE(apply({st}, {color}));
    EXPECT_TRUE(apply({}, {}));
    EXPECT_THROW(apply({}, {st}), std::invalid_argument);
}

}  // namespace
}  // namespace irt
