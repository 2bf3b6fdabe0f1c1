// SPDX-License-Identifier: Apache-2.0
// A node's value with its change across the footprint of the ray that asks (forward
// differentiation, so that textures know how much of them a pixel covers, whatever computes where
// they are read).
#pragma once

#include <array>

namespace irt::graph {

/// A number, and its differences along the two axes of the footprint. Unset unless given.
struct Dual {
    double v, x, y;
};

inline Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.x + b.x, a.y + b.y}; }
inline Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.x - b.x, a.y - b.y}; }
inline Dual operator*(const Dual& a, const Dual& b) {
    return {a.v * b.v, a.x * b.v + a.v * b.x, a.y * b.v + a.v * b.y};
}
/// f(a), where f is `value` and its derivative `slope` at a.
inline Dual chained(const Dual& a, double value, double slope) {
    return {value, slope * a.x, slope * a.y};
}

using Value = std::array<Dual, 4>;

}  // namespace irt::graph
