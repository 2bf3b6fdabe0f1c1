// SPDX-License-Identifier: Apache-2.0
// What a branch costs of the throughput that may be cut (DESIGN 3, rule 5).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>

#include "irt/math/vec.h"

namespace irt::shade {

/// Steps an octave of throughput in which branches are priced.
inline constexpr double price_scale = 16;

namespace detail {

/// Thirty-seconds of an octave's linear stretch, each with what floor(16 log2(m)) is at its lower
/// end and the one mantissa, if any, from which on it is one more. The mantissas are the least
/// floats that are at least 2^(k/16): between floats and the true powers there is so much room that
/// the rounding of no logarithm matters (tests/cpp/test_price.cpp compares every mantissa).
struct OctaveStretch {
    int steps;
    std::uint32_t mantissa;  ///< 23 bits
};

inline constexpr int stretches = 32, mantissa_bits = 23;

constexpr std::array<OctaveStretch, stretches> octave() {
    constexpr std::uint32_t steps[] = {0x05aac4, 0x0b95c2, 0x11c3d4, 0x1837f1, 0x1ef533,
                                       0x25fed7, 0x2d583f, 0x3504f4, 0x3d08a4, 0x45672b,
                                       0x4e248d, 0x5744fd, 0x60ccdf, 0x6ac0c7, 0x75257e};
    std::array<OctaveStretch, stretches> out{};
    for (std::uint32_t i = 0; i < stretches; ++i) {
        const std::uint32_t first = i << (mantissa_bits - 5);
        int passed = 0;
        while (passed < 15 && steps[passed] <= first) ++passed;
        out[i] = {passed, passed < 15 ? steps[passed] : 1u << mantissa_bits};
    }
    return out;
}

}  // namespace detail

/// A branch's price: the integer ceil(-16 log2(largest channel of its weight)); weights of 0 have
/// none. Sums of integers do not depend on where along a path they begin (DESIGN 3, rule 5).
inline std::optional<std::int64_t> price(const V3f& weight) {
    const double largest = static_cast<double>(std::max({weight.x, weight.y, weight.z}));
    if (!(largest > 0)) return std::nullopt;
    // ceil(-16 log2(m 2^e)) = -16 e - floor(16 log2(m)).
    static constexpr std::array<detail::OctaveStretch, detail::stretches> table = detail::octave();
    const auto bits = std::bit_cast<std::uint64_t>(largest);  // a double: never subnormal
    const auto exponent = static_cast<std::int64_t>(bits >> 52) - 1023;
    const auto mantissa = static_cast<std::uint32_t>(bits >> (52 - detail::mantissa_bits)) &
                          ((1u << detail::mantissa_bits) - 1);
    const detail::OctaveStretch& stretch = table[mantissa >> (detail::mantissa_bits - 5)];
    return -16 * exponent - stretch.steps - (mantissa >= stretch.mantissa ? 1 : 0);
}

}  // namespace irt::shade
