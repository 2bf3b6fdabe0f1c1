// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "irt/math/float_state.h"
#include "irt/math/libm.h"
#include "irt/texture/filter.h"
#include "irt/texture/rows.h"

namespace irt {

namespace {

constexpr double pi = std::numbers::pi;

/// A picture is summed up in at most so many rows of cells (0.7 degrees), twice as many columns.
constexpr int most_rows = 256;

/// The solid angle of one of `rows` circles of texels, counted from the top.
double solid_angle(int row, int rows) {
    return 2 * pi * (libm::cos(pi * row / rows) - libm::cos(pi * (row + 1) / rows));
}

}  // namespace

V3d seen_in(const Sky& sky, const V3d& direction, double spread) {
    const double x = direction.dot(sky.x), y = direction.dot(sky.y), z = direction.dot(sky.z);
    const double across = std::sqrt(x * x + z * z);
    const V2d st{0.5 - libm::atan2(x, z) / (2 * pi), 1 - libm::atan2(across, y) / pi};
    const double sine = across / std::sqrt(x * x + y * y + z * z);
    const double width = spread < 2 * pi * sine ? spread / (2 * pi * sine) : 1;
    const auto texel = texture::look_up(*sky.texture, Wrap::Repeat, Wrap::Clamp, st,
                                        {spread > 0 ? width : 0, 0}, {0, spread / pi});
    return texel ? V3d((*texel)[0], (*texel)[1], (*texel)[2]) : V3d(0, 0, 0);
}

std::vector<V3d> sky_directions(int count, const V3d& up) {
    if (count < 1) throw std::invalid_argument("a sky lights from one direction at least");
    const FloatState ieee;
    const V3d across = std::fabs(up.x) < 0.5 ? V3d(1, 0, 0) : V3d(0, 1, 0);
    const V3d side = normalized(across - up * across.dot(up)), third = side.cross(up);
    const double golden = pi * (3 - std::sqrt(5.0));
    std::vector<V3d> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z);
        directions.push_back(side * (r * libm::cos(golden * i)) + up * z +
                             third * (r * libm::sin(golden * i)));
    }
    return directions;
}

SkyCells::SkyCells(const Texture& texture) {
    const FloatState ieee;
    const Tile& tile = texture.tiles().front();
    const int height = tile.levels.front().height, width = tile.levels.front().width;
    rows_ = std::min(height, most_rows);
    columns_ = std::min(width, 2 * most_rows);
    const auto place = [](std::int64_t i, int cells, int count) {
        return static_cast<std::size_t>(i * cells / count);
    };
    cells_.assign(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_),
                  V3d(0, 0, 0));
    for (int row = 0; row < height; ++row) {
        V3d* const cells = &cells_[place(row, rows_, height) * static_cast<std::size_t>(columns_)];
        const double share = solid_angle(row, height) / width;
        const std::vector<V3d> colors = texture::row_of(texture, tile, row);
        for (int column = 0; column < width; ++column)
            for (int c = 0; c < 3; ++c)
                cells[place(column, columns_, width)][c] +=
                    share * std::max(colors[static_cast<std::size_t>(column)][c], 0.0);
    }
}

std::vector<V3d> SkyCells::irradiances(const V3d& x, const V3d& y, const V3d& z,
                                       const std::vector<V3d>& directions) const {
    const FloatState ieee;
    std::vector<V3d> irradiances(directions.size(), V3d(0, 0, 0));
    const V3d* cell = cells_.data();
    for (int row = 0; row < rows_; ++row) {
        const double polar = pi * (row + 0.5) / rows_;
        const double r = libm::sin(polar), height = libm::cos(polar);
        for (int column = 0; column < columns_; ++column, ++cell) {
            if (*cell == V3d(0, 0, 0)) continue;
            const double longitude = pi * (1 - 2 * (column + 0.5) / columns_);
            const V3d from =
                x * (r * libm::sin(longitude)) + y * height + z * (r * libm::cos(longitude));
            // Light travels the other way.
            const auto nearest = std::min_element(
                directions.begin(), directions.end(),
                [&](const V3d& a, const V3d& b) { return from.dot(a) < from.dot(b); });
            irradiances[static_cast<std::size_t>(nearest - directions.begin())] += *cell;
        }
    }
    return irradiances;
}

}  // namespace irt
