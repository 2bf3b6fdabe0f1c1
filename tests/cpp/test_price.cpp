// SPDX-License-Identifier: Apache-2.0
// Integer arithmetic that stands for calls of the C library: equal for every float.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "irt/math/libm.h"
#include "irt/shade/shading.h"
#include "irt/trace/ray_origin.h"

namespace irt {
namespace {

constexpr std::uint32_t octave = 1u << 23, infinite = 0x7f800000u;

bool priced_as_by_logarithm(std::uint32_t bits) {
    const float weight = std::bit_cast<float>(bits);
    const auto expected =
        static_cast<std::int64_t>(std::ceil(-16 * libm::log2(static_cast<double>(weight))));
    return shade::price(V3f(0, weight, 0)) == expected;
}

TEST(Price, EveryFloatAboveTheDefaultCutOffCostsItsLogarithm) {
    std::uint32_t wrong = 0;
    const auto first = std::bit_cast<std::uint32_t>(0x1p-11f);
    for (std::uint32_t bits = first; bits <= std::bit_cast<std::uint32_t>(2.0f); ++bits)
        wrong += priced_as_by_logarithm(bits) ? 0 : 1;
    EXPECT_EQ(wrong, 0u);
}

TEST(Price, OtherFloatsCostTheirLogarithmAroundEveryStep) {
    std::uint32_t wrong = 0;
    for (std::uint32_t start = 0; start < infinite; start += octave)
        for (int k = 0; k < 16; ++k) {
            const auto step = static_cast<std::uint32_t>((std::exp2(k / 16.0) - 1) * octave);
            for (std::uint32_t bits = start + step; bits < start + step + 8; ++bits)
                wrong += bits == 0 || priced_as_by_logarithm(bits - (k > 0 ? 4 : 0)) ? 0 : 1;
        }
    for (std::uint32_t bits = 1; bits < infinite; bits += 997)  // subnormal weights among them
        wrong += priced_as_by_logarithm(bits) ? 0 : 1;
    EXPECT_EQ(wrong, 0u);
}

TEST(Price, NoWeightHasNone) {
    EXPECT_FALSE(shade::price(V3f(0, 0, 0)));
    EXPECT_FALSE(shade::price(V3f(-1, 0, -0.0f)));
    EXPECT_FALSE(shade::price(V3f(std::numeric_limits<float>::quiet_NaN(), 0, 0)));
}

TEST(RayOrigin, StepsAsNextafterDoes) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    std::uint32_t wrong = 0;
    const auto compare = [&](float f) {
        const auto same = [](float a, float b) {
            return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
        };
        wrong += same(trace::stepped(f, 0), f) ? 0 : 1;
        if (f < infinity) wrong += same(trace::stepped(f, 1), std::nextafter(f, infinity)) ? 0 : 1;
        if (f > -infinity)
            wrong += same(trace::stepped(f, -1), std::nextafter(f, -infinity)) ? 0 : 1;
    };
    for (std::uint32_t bits = 0; bits <= infinite;
         bits += bits < 9 || bits > infinite - 999 ? 1 : 499) {
        compare(std::bit_cast<float>(bits));
        compare(-std::bit_cast<float>(bits));
    }
    compare(infinity);
    compare(-infinity);
    EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace irt
