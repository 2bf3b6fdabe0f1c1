// SPDX-License-Identifier: Apache-2.0
#include "irt/graph/operations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "irt/graph/noise.h"
#include "irt/math/libm.h"

namespace irt::graph {

namespace {

constexpr Dual zero{}, one{1, 0, 0};

template <class F>
Value each(const Value& a, F&& f) {
    return {f(a[0]), f(a[1]), f(a[2]), f(a[3])};
}
template <class F>
Value each(const Value& a, const Value& b, F&& f) {
    return {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])};
}

/// A step function, flat where it is not broken.
template <class F>
Value steps(const Value& a, F&& f) {
    return each(a, [&](const Dual& d) { return Dual{f(d.v), 0, 0}; });
}

Dual quotient(const Dual& a, const Dual& b) {
    if (b.v == 0) return zero;
    const double value = a.v / b.v;
    return {value, (a.x - value * b.x) / b.v, (a.y - value * b.y) / b.v};
}

Dual least(const Dual& a, const Dual& b) { return b.v < a.v ? b : a; }
Dual greatest(const Dual& a, const Dual& b) { return b.v > a.v ? b : a; }

Dual power(const Dual& a, const Dual& b) {
    const double value = libm::pow(a.v, b.v);
    if (!std::isfinite(value)) return zero;
    // The exponent is a constant nearly always; where it is not its share of the change is left
    // out.
    const double slope = a.v != 0 ? b.v * value / a.v : 0;
    return chained(a, value, slope);
}

Dual modulo(const Dual& a, const Dual& b) {
    if (b.v == 0) return zero;
    return {a.v - b.v * std::floor(a.v / b.v), a.x, a.y};
}

Dual square_root(const Dual& a) {
    if (!(a.v > 0)) return zero;
    const double value = std::sqrt(a.v);
    return chained(a, value, 0.5 / value);
}

Dual smooth_step(const Dual& in, const Dual& low, const Dual& high) {
    if (in.v <= low.v) return zero;
    if (in.v >= high.v) return one;
    const Dual t = quotient(in - low, high - low);
    return t * t * (Dual{3, 0, 0} - Dual{2, 0, 0} * t);
}

Dual dot(const Value& a, const Value& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Value normalized(const Value& a) {
    const Dual length = square_root(dot(a, a));
    return {quotient(a[0], length), quotient(a[1], length), quotient(a[2], length), a[3]};
}

Value cross(const Value& a, const Value& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], zero};
}

/// Sine and cosine of an angle in degrees, exact at right angles.
struct Turn {
    double sine, cosine;
};
Turn turn(double degrees) {
    if (!std::isfinite(degrees)) return {0, 1};
    const double turned = degrees - 360 * std::floor(degrees / 360);
    const double quadrant = std::floor(turned / 90);
    const double radians = (turned - 90 * quadrant) * (std::numbers::pi / 180);
    const double s = libm::sin(radians), c = libm::cos(radians);
    switch (static_cast<int>(quadrant)) {
        case 1:
            return {c, -s};
        case 2:
            return {-s, -c};
        case 3:
            return {-c, s};
        default:
            return {s, c};
    }
}

/// UsdTransform2d: in * scale, turned counter-clockwise, + translation.
Value transform2d(const Value& in, const Value& scale, const Value& rotation,
                  const Value& translation) {
    const Turn by = turn(rotation[0].v);
    const Dual s{by.sine, 0, 0}, c{by.cosine, 0, 0};
    const Dual x = in[0] * scale[0], y = in[1] * scale[1];
    return {x * c - y * s + translation[0], x * s + y * c + translation[1], in[2], in[3]};
}

/// Between the colour models as MaterialX has them (hue in [0, 1]); changes are not followed.
Value rgb_to_hsv(const Value& in) {
    const double r = in[0].v, g = in[1].v, b = in[2].v;
    const double most = std::max({r, g, b}), delta = most - std::min({r, g, b});
    double hue = 0;
    if (delta > 0) {
        if (r >= most)
            hue = (g - b) / delta;
        else if (g >= most)
            hue = 2 + (b - r) / delta;
        else
            hue = 4 + (r - g) / delta;
        hue /= 6;
        if (hue < 0) hue += 1;
    }
    return {Dual{hue, 0, 0}, {most > 0 ? delta / most : 0, 0, 0}, {most, 0, 0}, in[3]};
}

Value hsv_to_rgb(const Value& in) {
    const double saturation = in[1].v, v = in[2].v;
    const double h = 6 * (in[0].v - std::floor(in[0].v)), sector = std::floor(h), f = h - sector;
    const double p = v * (1 - saturation), q = v * (1 - saturation * f),
                 t = v * (1 - saturation * (1 - f));
    const auto value = [&](double r, double g, double b) {
        return Value{Dual{r, 0, 0}, {g, 0, 0}, {b, 0, 0}, in[3]};
    };
    if (!(h >= 0 && h < 6)) return value(v, t, p);
    switch (static_cast<int>(sector)) {
        case 0:
            return value(v, t, p);
        case 1:
            return value(q, v, p);
        case 2:
            return value(p, v, t);
        case 3:
            return value(p, q, v);
        case 4:
            return value(t, p, v);
        default:
            return value(v, p, q);
    }
}

/// Of what lies outside [-1, 1] as of its ends, where it is flat.
Dual arc_sine(const Dual& a) {
    if (!(std::fabs(a.v) < 1)) return {libm::asin(a.v < 0 ? -1.0 : 1.0), 0, 0};
    return chained(a, libm::asin(a.v), 1 / std::sqrt(1 - a.v * a.v));
}

Dual arc_cosine(const Dual& a) {
    if (!(std::fabs(a.v) < 1)) return {libm::acos(a.v < 0 ? -1.0 : 1.0), 0, 0};
    return chained(a, libm::acos(a.v), -1 / std::sqrt(1 - a.v * a.v));
}

Dual arc_tangent(const Dual& y, const Dual& x) {
    const double squared = x.v * x.v + y.v * y.v;
    if (!(squared > 0)) return zero;
    return {libm::atan2(y.v, x.v), (x.v * y.x - y.v * x.x) / squared,
            (x.v * y.y - y.v * x.y) / squared};
}

Point2 flat(const Value& a) { return {a[0].v, a[1].v}; }
Point3 solid(const Value& a) { return {a[0].v, a[1].v, a[2].v}; }

/// Numbers whose change across the footprint is not followed.
Value still(double v) { return {Dual{v, 0, 0}, {v, 0, 0}, {v, 0, 0}, {v, 0, 0}}; }
Value still(const std::array<double, 3>& v) {
    return {Dual{v[0], 0, 0}, {v[1], 0, 0}, {v[2], 0, 0}, zero};
}
Value still(const std::array<double, 4>& v) {
    return {Dual{v[0], 0, 0}, {v[1], 0, 0}, {v[2], 0, 0}, {v[3], 0, 0}};
}

Dual picked(const Value& in, std::uint8_t component) {
    if (component == swizzle_zero) return zero;
    return component == swizzle_one ? one : in[component];
}

}  // namespace

Value operate(const ShadeNode& node, const std::array<Value, 4>& slots) {
    const auto& [a, b, c, d] = slots;
    switch (node.op) {
        case Op::Constant:
        case Op::Primvar:
        case Op::Texture:
        case Op::Position:
        case Op::Normal:
        case Op::View:
        case Op::PointToWorld:
        case Op::VectorToWorld:
        case Op::NormalToWorld:
        case Op::PointToObject:
        case Op::VectorToObject:
        case Op::NormalToObject:
            return a;
        case Op::Transform2d:
            return transform2d(a, b, c, d);
        case Op::Add:
            return each(a, b, [](const Dual& x, const Dual& y) { return x + y; });
        case Op::Subtract:
            return each(a, b, [](const Dual& x, const Dual& y) { return x - y; });
        case Op::Multiply:
            return each(a, b, [](const Dual& x, const Dual& y) { return x * y; });
        case Op::Divide:
            return each(a, b, quotient);
        case Op::Min:
            return each(a, b, least);
        case Op::Max:
            return each(a, b, greatest);
        case Op::Power:
            return each(a, b, power);
        case Op::Modulo:
            return each(a, b, modulo);
        case Op::Clamp:
            return each(each(a, b, greatest), c, least);
        case Op::Mix:
            return {a[0] + (b[0] - a[0]) * c[0], a[1] + (b[1] - a[1]) * c[1],
                    a[2] + (b[2] - a[2]) * c[2], a[3] + (b[3] - a[3]) * c[3]};
        case Op::Smoothstep:
            return {smooth_step(a[0], b[0], c[0]), smooth_step(a[1], b[1], c[1]),
                    smooth_step(a[2], b[2], c[2]), smooth_step(a[3], b[3], c[3])};
        case Op::Absolute:
            return each(a, [](const Dual& x) { return x.v < 0 ? zero - x : x; });
        case Op::Sign:
            return steps(a, [](double v) { return v > 0 ? 1.0 : (v < 0 ? -1.0 : 0.0); });
        case Op::Floor:
            return steps(a, [](double v) { return std::floor(v); });
        case Op::Ceil:
            return steps(a, [](double v) { return std::ceil(v); });
        case Op::Round:
            return steps(a, [](double v) { return std::floor(v + 0.5); });
        case Op::Sqrt:
            return each(a, square_root);
        case Op::Sin:
            return each(a,
                        [](const Dual& x) { return chained(x, libm::sin(x.v), libm::cos(x.v)); });
        case Op::Cos:
            return each(a,
                        [](const Dual& x) { return chained(x, libm::cos(x.v), -libm::sin(x.v)); });
        case Op::Exp:
            return each(a, [](const Dual& x) {
                const double value = libm::exp(x.v);
                return chained(x, value, value);
            });
        case Op::Log:
            return each(a, [](const Dual& x) {
                return x.v > 0 ? chained(x, libm::log(x.v), 1 / x.v) : zero;
            });
        case Op::Dot: {
            const Dual sum = dot(a, b);
            return {sum, sum, sum, sum};
        }
        case Op::Length: {
            const Dual length = square_root(dot(a, a));
            return {length, length, length, length};
        }
        case Op::Normalize:
            return normalized(a);
        case Op::Cross:
            return cross(a, b);
        case Op::IfGreater:
            return {a[0].v > b[0].v ? c[0] : d[0], a[1].v > b[1].v ? c[1] : d[1],
                    a[2].v > b[2].v ? c[2] : d[2], a[3].v > b[3].v ? c[3] : d[3]};
        case Op::IfEqual:
            return {a[0].v == b[0].v ? c[0] : d[0], a[1].v == b[1].v ? c[1] : d[1],
                    a[2].v == b[2].v ? c[2] : d[2], a[3].v == b[3].v ? c[3] : d[3]};
        case Op::Swizzle:
            return {picked(a, node.swizzle[0]), picked(a, node.swizzle[1]),
                    picked(a, node.swizzle[2]), picked(a, node.swizzle[3])};
        case Op::Combine:
            return {a[0], b[0], c[0], d[0]};
        case Op::RgbToHsv:
            return rgb_to_hsv(a);
        case Op::HsvToRgb:
            return hsv_to_rgb(a);
        case Op::Asin:
            return each(a, arc_sine);
        case Op::Acos:
            return each(a, arc_cosine);
        case Op::Atan2:
            return each(a, b, arc_tangent);
        case Op::Perlin2:
            return still(perlin(flat(a)));
        case Op::Perlin3:
            return still(perlin(solid(a)));
        case Op::PerlinVector2:
            return still(perlin_vector(flat(a)));
        case Op::PerlinVector3:
            return still(perlin_vector(solid(a)));
        case Op::Cells2:
            return still(cells(flat(a)));
        case Op::Cells3:
            return still(cells(solid(a)));
        case Op::Worley2:
            return still(worley(flat(a), b[0].v));
        case Op::Worley3:
            return still(worley(solid(a), b[0].v));
        case Op::WorleyCells2:
            return still(worley_cells(flat(a), b[0].v));
        case Op::WorleyCells3:
            return still(worley_cells(solid(a), b[0].v));
    }
    return a;
}

}  // namespace irt::graph
