// SPDX-License-Identifier: Apache-2.0
// Shading graphs: their arithmetic, its derivatives, and materials that use them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "irt/graph/operations.h"
#include "irt/scene/compile.h"
#include "irt/scene/equality.h"

namespace irt::graph {
namespace {

Dual dual(double v, double x = 0, double y = 0) { return {v, x, y}; }
Value all(double v) { return {dual(v), dual(v), dual(v), dual(v)}; }
Value vector(double a, double b, double c, double d = 1) {
    return {dual(a), dual(b), dual(c), dual(d)};
}
std::array<double, 4> numbers(const Value& v) { return {v[0].v, v[1].v, v[2].v, v[3].v}; }

Value value_of(Op op, const Value& a, const Value& b = {}, const Value& c = {},
               const Value& d = {}) {
    ShadeNode node;
    node.op = op;
    return operate(node, {a, b, c, d});
}

double first(Op op, double a, double b = 0, double c = 0, double d = 0) {
    return value_of(op, all(a), all(b), all(c), all(d))[0].v;
}

TEST(Operations, HaveTheirValues) {
    EXPECT_EQ(first(Op::Add, 2, 3), 5);
    EXPECT_EQ(first(Op::Subtract, 2, 3), -1);
    EXPECT_EQ(first(Op::Multiply, 2, 3), 6);
    EXPECT_EQ(first(Op::Divide, 3, 2), 1.5);
    EXPECT_EQ(first(Op::Divide, 3, 0), 0);
    EXPECT_EQ(first(Op::Min, 2, 3), 2);
    EXPECT_EQ(first(Op::Max, 2, 3), 3);
    EXPECT_EQ(first(Op::Power, 2, 3), 8);
    EXPECT_EQ(first(Op::Power, -2, 0.5), 0);
    EXPECT_EQ(first(Op::Power, 0, -1), 0);
    EXPECT_EQ(first(Op::Modulo, -1, 3), 2);
    EXPECT_EQ(first(Op::Modulo, 1, 0), 0);
    EXPECT_EQ(first(Op::Clamp, 5, 0, 1), 1);
    EXPECT_EQ(first(Op::Clamp, -5, 0, 1), 0);
    EXPECT_EQ(first(Op::Mix, 1, 3, 0.25), 1.5);
    EXPECT_EQ(first(Op::Smoothstep, 0.25, 0, 1), 0.15625);
    EXPECT_EQ(first(Op::Smoothstep, 2, 0, 1), 1);
    EXPECT_EQ(first(Op::Smoothstep, 0.5, 0.5, 0.5), 0);
    EXPECT_EQ(first(Op::Absolute, -2), 2);
    EXPECT_EQ(first(Op::Sign, -2), -1);
    EXPECT_EQ(first(Op::Sign, 0), 0);
    EXPECT_EQ(first(Op::Floor, -0.5), -1);
    EXPECT_EQ(first(Op::Ceil, 0.5), 1);
    EXPECT_EQ(first(Op::Round, 0.5), 1);
    EXPECT_EQ(first(Op::Sqrt, 9), 3);
    EXPECT_EQ(first(Op::Sqrt, -9), 0);
    EXPECT_EQ(first(Op::Log, 0), 0);
    EXPECT_EQ(first(Op::Exp, 0), 1);
    EXPECT_EQ(first(Op::Sin, 0), 0);
    EXPECT_EQ(first(Op::Cos, 0), 1);
    EXPECT_EQ(first(Op::IfGreater, 2, 1, 5, 6), 5);
    EXPECT_EQ(first(Op::IfGreater, 1, 1, 5, 6), 6);
    EXPECT_EQ(first(Op::IfEqual, 1, 1, 5, 6), 5);
    const Value a = vector(1, 2, 2, 7), b = vector(3, 4, 5, 6);
    EXPECT_EQ(numbers(value_of(Op::Dot, a, b)), (std::array<double, 4>{21, 21, 21, 21}));
    EXPECT_EQ(numbers(value_of(Op::Length, a)), (std::array<double, 4>{3, 3, 3, 3}));
    EXPECT_EQ(numbers(value_of(Op::Normalize, a)),
              (std::array<double, 4>{1 / 3.0, 2 / 3.0, 2 / 3.0, 7}));
    EXPECT_EQ(numbers(value_of(Op::Normalize, vector(0, 0, 0, 1))),
              (std::array<double, 4>{0, 0, 0, 1}));
    EXPECT_EQ(numbers(value_of(Op::Cross, vector(1, 0, 0), vector(0, 1, 0))),
              (std::array<double, 4>{0, 0, 1, 0}));
    EXPECT_EQ(numbers(value_of(Op::Combine, all(1), all(2), all(3), all(4))),
              (std::array<double, 4>{1, 2, 3, 4}));
    ShadeNode swizzle;
    swizzle.op = Op::Swizzle;
    swizzle.swizzle = {3, 0, swizzle_zero, swizzle_one};
    EXPECT_EQ(numbers(operate(swizzle, {a, a, a, a})), (std::array<double, 4>{7, 1, 0, 1}));
}

TEST(Operations, TransformIsThatOfUsdTransform2d) {
    const auto transformed = [](const V2d& st, double scale, double degrees, const V2d& offset) {
        const Value out = value_of(Op::Transform2d, vector(st.x, st.y, 0), all(scale), all(degrees),
                                   vector(offset.x, offset.y, 0));
        return V2d(out[0].v, out[1].v);
    };
    EXPECT_EQ(transformed({1, 2}, 1, 0, {0, 0}), V2d(1, 2));
    EXPECT_EQ(transformed({1, 2}, 3, 0, {0.5, 0}), V2d(3.5, 6));
    EXPECT_EQ(transformed({1, 2}, 1, 90, {0, 0}), V2d(-2, 1)) << "counter-clockwise, and exact";
    EXPECT_EQ(transformed({1, 2}, 1, 180, {0, 0}), V2d(-1, -2));
    EXPECT_EQ(transformed({1, 2}, 1, -90, {0, 0}), V2d(2, -1));
    EXPECT_EQ(transformed({1, 2}, 1, 3600, {0, 0}), V2d(1, 2));
    const V2d turned = transformed({1, 0}, 2, 30, {1, 1});
    EXPECT_NEAR(turned.x, 1 + std::sqrt(3), 1e-15);
    EXPECT_NEAR(turned.y, 2, 1e-15);
}

TEST(Operations, ColourModelsAreInverse) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int trial = 0; trial < 500; ++trial) {
        const Value rgb = vector(unit(random), unit(random), unit(random));
        const Value back = value_of(Op::HsvToRgb, value_of(Op::RgbToHsv, rgb));
        for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(back[c].v, rgb[c].v, 1e-12);
    }
    EXPECT_EQ(numbers(value_of(Op::RgbToHsv, vector(0, 1, 0))),
              (std::array<double, 4>{1 / 3.0, 1, 1, 1}));
}

/// Differences are those of the values, to first order.
TEST(Operations, DerivativesAreThoseOfTheValues) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0.1, 1);
    constexpr double step = 1e-6;
    for (const Op op :
         {Op::Transform2d, Op::Add,   Op::Subtract,  Op::Multiply,   Op::Divide,   Op::Min,
          Op::Max,         Op::Clamp, Op::Mix,       Op::Smoothstep, Op::Absolute, Op::Sqrt,
          Op::Sin,         Op::Cos,   Op::Exp,       Op::Log,        Op::Dot,      Op::Length,
          Op::Normalize,   Op::Cross, Op::IfGreater, Op::Combine,    Op::Atan2})
        for (int trial = 0; trial < 20; ++trial) {
            std::array<Value, 4> slots{}, moved{};
            for (std::size_t s = 0; s < 4; ++s)
                for (std::size_t c = 0; c < 4; ++c) {
                    slots[s][c] = dual(unit(random), unit(random), unit(random));
                    if (op == Op::Transform2d && s == 2) slots[s][c].x = 0;  // turns stand still
                    moved[s][c] = dual(slots[s][c].v + step * slots[s][c].x);
                }
            ShadeNode node;
            node.op = op;
            const Value at = operate(node, slots), there = operate(node, moved);
            for (std::size_t c = 0; c < 4; ++c)
                EXPECT_NEAR((there[c].v - at[c].v) / step, at[c].x, 1e-3)
                    << op_names[static_cast<std::size_t>(op)];
        }
}

// ---- materials

Material cut_by(std::vector<ShadeNode> nodes) {
    Material m;
    m.nodes = std::move(nodes);
    m.connected[static_cast<std::size_t>(SurfaceInput::Opacity)] = {
        static_cast<std::int32_t>(m.nodes.size()) - 1, 0};
    return m;
}

ShadeNode half_as_much() {
    ShadeNode node;
    node.op = Op::Multiply;
    node.constants[0] = node.constants[1] = {0.5f, 0.5f, 0.5f, 0.5f};
    return node;
}

TEST(Materials, BrokenGraphsAreRefused) {
    ShadeNode loop = half_as_much();
    loop.inputs[0] = 0;
    EXPECT_THROW(check(cut_by({loop}), "m"), std::invalid_argument);
    ShadeNode texture;
    texture.op = Op::Texture;
    EXPECT_THROW(check(cut_by({texture}), "m"), std::invalid_argument);
    Material dangling = cut_by({half_as_much()});
    dangling.nodes.clear();
    EXPECT_THROW(check(dangling, "m"), std::invalid_argument);
    EXPECT_THROW(check(cut_by(std::vector(max_shade_nodes + 1, half_as_much())), "m"),
                 std::invalid_argument);
    EXPECT_NO_THROW(check(cut_by({half_as_much()}), "m"));
}

TEST(Materials, AreUniformUnlessSomethingIsConnected) {
    EXPECT_TRUE(is_uniform(Material()));
    EXPECT_FALSE(is_uniform(cut_by({half_as_much()})));
    Material bent;
    bent.normal = {0.1f, 0, 1};
    EXPECT_FALSE(is_uniform(bent));
}

TEST(Materials, TintIsThatOfWhatShadowRaysRead) {
    const Material a = cut_by({half_as_much()});
    Material b = a;
    EXPECT_TRUE(same_tint(a, b));
    b.roughness = 0.1f;
    b.nodes.push_back(half_as_much());
    b.connected[static_cast<std::size_t>(SurfaceInput::Metallic)] = {1, 0};
    EXPECT_TRUE(same_tint(a, b)) << "what else the material has does not matter";
    EXPECT_FALSE(same(a, b));
    std::swap(b.nodes[0], b.nodes[1]);
    b.connected[static_cast<std::size_t>(SurfaceInput::Opacity)].node = 1;
    EXPECT_TRUE(same_tint(a, b)) << "nor where its nodes stand";
    b.nodes[1].constants[0][0] = 0.25f;
    EXPECT_FALSE(same_tint(a, b));
    Material painted;
    painted.nodes = {half_as_much()};
    painted.connected[static_cast<std::size_t>(SurfaceInput::DiffuseColor)] = {0, Connection::rgb};
    EXPECT_TRUE(same_tint(painted, Material())) << "opaque, whatever its colour";
    painted.opacity = 0.5f;
    EXPECT_FALSE(same_tint(painted, Material()));
}

TEST(Materials, NodesBehindAnInputAreAllItDependsOn) {
    std::vector<ShadeNode> nodes(5, half_as_much());
    nodes[2].inputs[1] = 0;
    nodes[4].inputs[0] = 2;
    EXPECT_EQ(nodes_behind(cut_by(nodes), {SurfaceInput::Opacity}),
              (std::vector<std::int32_t>{0, 2, 4}));
    EXPECT_TRUE(nodes_behind(cut_by(nodes), {SurfaceInput::Roughness}).empty());
}

}  // namespace
}  // namespace irt::graph
