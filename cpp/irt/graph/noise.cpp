// SPDX-License-Identifier: Apache-2.0
#include "irt/graph/noise.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace irt::graph {

namespace {

template <std::size_t n>
using Cell = std::array<std::uint32_t, n>;
template <std::size_t n>
using Point = std::array<double, n>;

/// The cell of a coordinate, modulo 2^32: coordinates far out have one too, and those that are no
/// number cell 0.
std::uint32_t cell_of(double x) {
    const double whole = std::floor(x);
    if (!std::isfinite(whole)) return 0;
    constexpr double range = 4294967296.0;
    return static_cast<std::uint32_t>(whole - range * std::floor(whole / range));
}

double fraction(double x) {
    const double rest = x - std::floor(x);
    return std::isfinite(rest) ? rest : 0;
}

template <std::size_t n>
Cell<n> cell_of(const Point<n>& p) {
    Cell<n> cell;
    for (std::size_t i = 0; i < n; ++i) cell[i] = cell_of(p[i]);
    return cell;
}

template <std::size_t n>
Point<n> fraction(const Point<n>& p) {
    Point<n> rest;
    for (std::size_t i = 0; i < n; ++i) rest[i] = fraction(p[i]);
    return rest;
}

void mix(std::uint32_t& a, std::uint32_t& b, std::uint32_t& c) {
    // clang-format off
    a -= c; a ^= std::rotl(c, 4);  c += b;
    b -= a; b ^= std::rotl(a, 6);  a += c;
    c -= b; c ^= std::rotl(b, 8);  b += a;
    a -= c; a ^= std::rotl(c, 16); c += b;
    b -= a; b ^= std::rotl(a, 19); a += c;
    c -= b; c ^= std::rotl(b, 4);  b += a;
    // clang-format on
}

std::uint32_t final_mix(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    // clang-format off
    c ^= b; c -= std::rotl(b, 14);
    a ^= c; a -= std::rotl(c, 11);
    b ^= a; b -= std::rotl(a, 25);
    c ^= b; c -= std::rotl(b, 16);
    a ^= c; a -= std::rotl(c, 4);
    b ^= a; b -= std::rotl(a, 14);
    c ^= b; c -= std::rotl(b, 24);
    // clang-format on
    return c;
}

/// Of 2 to 4 numbers.
template <std::size_t n>
std::uint32_t hash(const Cell<n>& key) {
    const std::uint32_t seed = 0xdeadbeefu + (static_cast<std::uint32_t>(n) << 2) + 13u;
    std::uint32_t a = seed + key[0], b = seed + key[1], c = seed;
    if constexpr (n > 2) c += key[2];
    if constexpr (n > 3) {
        mix(a, b, c);
        a += key[3];
    }
    return final_mix(a, b, c);
}

double unit(std::uint32_t bits) {
    return static_cast<double>(bits) / static_cast<double>(0xffffffffu);
}

template <std::size_t n>
Point3 random_of(const Cell<n>& cell) {
    Cell<n + 1> key{};
    for (std::size_t i = 0; i < n; ++i) key[i] = cell[i];
    Point3 numbers;
    for (std::uint32_t i = 0; i < 3; ++i) {
        key[n] = i;
        numbers[i] = unit(hash(key));
    }
    return numbers;
}

double signed_by(double value, bool negative) { return negative ? -value : value; }

double gradient(std::uint32_t hash, const Point2& p) {
    const std::uint32_t h = hash & 7u;
    const double u = h < 4 ? p[0] : p[1], v = 2 * (h < 4 ? p[1] : p[0]);
    return signed_by(u, h & 1u) + signed_by(v, h & 2u);
}

double gradient(std::uint32_t hash, const Point3& p) {
    const std::uint32_t h = hash & 15u;
    const double u = h < 8 ? p[0] : p[1];
    const double v = h < 4 ? p[1] : (h == 12 || h == 14 ? p[0] : p[2]);
    return signed_by(u, h & 1u) + signed_by(v, h & 2u);
}

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

/// The gradient's largest value, about.
template <std::size_t n>
constexpr double perlin_scale = n == 2 ? 0.6616 : 0.9820;

/// The gradients at a cell's corners, by the bits of their hashes from `shift` on, blended.
template <std::size_t n>
double blended(const std::array<std::uint32_t, (1u << n)>& hashes, int shift,
               const Point<n>& rest) {
    std::array<double, (1u << n)> values;
    for (std::size_t corner = 0; corner < values.size(); ++corner) {
        Point<n> offset = rest;
        for (std::size_t i = 0; i < n; ++i)
            if (corner >> i & 1u) offset[i] -= 1;
        values[corner] = gradient(hashes[corner] >> shift, offset);
    }
    std::size_t left = values.size();
    for (std::size_t i = 0; i < n; ++i) {
        const double t = fade(rest[i]);
        left /= 2;
        for (std::size_t k = 0; k < left; ++k)
            values[k] = (1 - t) * values[2 * k] + t * values[2 * k + 1];
    }
    return perlin_scale<n> * values[0];
}

template <std::size_t n>
std::array<std::uint32_t, (1u << n)> corner_hashes(const Cell<n>& cell) {
    std::array<std::uint32_t, (1u << n)> hashes;
    for (std::size_t corner = 0; corner < hashes.size(); ++corner) {
        Cell<n> at = cell;
        for (std::size_t i = 0; i < n; ++i) at[i] += static_cast<std::uint32_t>(corner >> i & 1u);
        hashes[corner] = hash(at);
    }
    return hashes;
}

template <std::size_t n>
double perlin_at(const Point<n>& p) {
    return blended<n>(corner_hashes<n>(cell_of<n>(p)), 0, fraction<n>(p));
}

template <std::size_t n>
Point3 perlin_vector_at(const Point<n>& p) {
    const auto hashes = corner_hashes<n>(cell_of<n>(p));
    const Point<n> rest = fraction<n>(p);
    return {blended<n>(hashes, 0, rest), blended<n>(hashes, 8, rest), blended<n>(hashes, 16, rest)};
}

/// The nearest three of the points in the cells around `p`.
template <std::size_t n>
struct Nearest {
    std::array<double, 3> squared;
    Point<n> to_nearest{};

    Nearest(const Point<n>& p, double jitter) {
        // What MaterialX has for nothing found.
        constexpr double far = 1e6;
        squared = {far, far, far};
        const Cell<n> home = cell_of<n>(p);
        const Point<n> rest = fraction<n>(p);
        constexpr std::size_t count = n == 2 ? 9 : 27;
        for (std::size_t k = 0; k < count; ++k) {
            // The first coordinate changes slowest: among equals the first counts.
            Point<n> step;
            Cell<n> cell = home;
            for (std::size_t i = 0, rest_of_k = k; i < n; ++i, rest_of_k /= 3) {
                const std::size_t axis = n - 1 - i;
                step[axis] = static_cast<double>(rest_of_k % 3) - 1;
                cell[axis] += static_cast<std::uint32_t>(rest_of_k % 3) - 1u;
            }
            const Point3 random = random_of<n>(cell);
            Point<n> to;
            double distance = 0;
            for (std::size_t i = 0; i < n; ++i) {
                to[i] = step[i] + ((random[i] - 0.5) * jitter + 0.5) - rest[i];
                distance += to[i] * to[i];
            }
            insert(distance, to);
        }
    }

  private:
    void insert(double distance, const Point<n>& to) {
        if (distance < squared[0]) {
            squared = {distance, squared[0], squared[1]};
            to_nearest = to;
        } else if (distance < squared[1]) {
            squared = {squared[0], distance, squared[1]};
        } else if (distance < squared[2]) {
            squared[2] = distance;
        }
    }
};

template <std::size_t n>
Point3 worley_at(const Point<n>& p, double jitter) {
    const Nearest<n> nearest(p, jitter);
    return {std::sqrt(nearest.squared[0]), std::sqrt(nearest.squared[1]),
            std::sqrt(nearest.squared[2])};
}

template <std::size_t n>
std::array<double, 4> worley_cells_at(const Point<n>& p, double jitter) {
    const Nearest<n> nearest(p, jitter);
    Point<n> at;
    for (std::size_t i = 0; i < n; ++i) at[i] = p[i] + nearest.to_nearest[i];
    const Cell<n> cell = cell_of<n>(at);
    const Point3 random = random_of<n>(cell);
    return {random[0], random[1], random[2], unit(hash(cell))};
}

}  // namespace

double perlin(const Point2& p) { return perlin_at<2>(p); }
double perlin(const Point3& p) { return perlin_at<3>(p); }
Point3 perlin_vector(const Point2& p) { return perlin_vector_at<2>(p); }
Point3 perlin_vector(const Point3& p) { return perlin_vector_at<3>(p); }
double cells(const Point2& p) { return unit(hash(cell_of<2>(p))); }
double cells(const Point3& p) { return unit(hash(cell_of<3>(p))); }
Point3 worley(const Point2& p, double jitter) { return worley_at<2>(p, jitter); }
Point3 worley(const Point3& p, double jitter) { return worley_at<3>(p, jitter); }
std::array<double, 4> worley_cells(const Point2& p, double jitter) {
    return worley_cells_at<2>(p, jitter);
}
std::array<double, 4> worley_cells(const Point3& p, double jitter) {
    return worley_cells_at<3>(p, jitter);
}

}  // namespace irt::graph
