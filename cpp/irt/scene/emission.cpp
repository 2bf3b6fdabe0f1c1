// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/emission.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "irt/math/libm.h"

namespace irt {

namespace {

constexpr double degrees = std::numbers::pi / 180;

double smoothstep(double x, double low, double high) {
    if (x <= low) return 0;
    if (x >= high) return 1;
    const double t = (x - low) / (high - low);
    return t * t * (3 - 2 * t);
}

/// The projected area of the emitter: as a share of the greatest, or for a mesh as it is.
double far_field(const Light& light, const V3d& direction, double along_axis, double squared) {
    switch (light.profile) {
        case Profile::Uniform:
            return 1;
        case Profile::Facing:
            return std::max(along_axis, 0.0);
        case Profile::Round: {
            const double along = direction.dot(light.side);
            return std::sqrt(std::max(1 - along * along, 0.0));
        }
        case Profile::Facets: {
            // A disk of area a sends to a point on its axis, at the distance d, as a point would
            // from the root of d^2 + a / pi.
            const V3d point = direction * std::sqrt(squared);
            double sum = 0;
            for (const Facet& facet : light.facets) {
                const V3d area(facet.area), way = point - V3d(facet.offset);
                const double turned = area.dot(way), distance = way.dot(way);
                if (!(turned > 0)) continue;
                sum += turned / std::sqrt(distance) /
                       (distance + std::sqrt(area.dot(area)) / std::numbers::pi);
            }
            return sum * squared;
        }
    }
    return 1;
}

/// 1 within the cone, 0 beyond its angle, smooth over the `softness` of it between.
double cone(const Light& light, double along_axis) {
    const double edge = static_cast<double>(light.cone_angle) * degrees;
    if (edge >= std::numbers::pi) return 1;
    const double softness = std::clamp(static_cast<double>(light.cone_softness), 0.0, 1.0);
    const double angle = libm::acos(std::clamp(along_axis, -1.0, 1.0));
    if (angle > edge) return 0;
    return 1 - smoothstep(angle, edge * (1 - softness), edge);
}

/// Linear in both angles of the photometric web, about the axis; constant beyond its ends.
double web(const IesWeb& web, const Light& light, const V3d& direction, double along_axis) {
    const auto place = [](const std::vector<float>& angles, double angle) {
        std::size_t i = 0;
        while (i + 2 < angles.size() && static_cast<double>(angles[i + 1]) <= angle) ++i;
        if (angles.size() < 2) return std::pair(std::size_t{0}, 0.0);
        const double low = static_cast<double>(angles[i]),
                     high = static_cast<double>(angles[i + 1]);
        return std::pair(i, std::clamp((angle - low) / (high - low), 0.0, 1.0));
    };
    const double polar = libm::acos(std::clamp(along_axis, -1.0, 1.0)) / degrees;
    if (polar < static_cast<double>(web.vertical.front()) ||
        polar > static_cast<double>(web.vertical.back()))
        return 0;
    const V3d up = light.side.cross(light.direction);
    double around = libm::atan2(direction.dot(up), direction.dot(light.side)) / degrees;
    if (around < 0) around += 360;
    const double last = static_cast<double>(web.horizontal.back());
    if (last <= 180 && around > 180) around = 360 - around;  // bilateral, or quadrants
    if (last <= 90 && around > 90) around = 180 - around;
    const auto [v, fv] = place(web.vertical, polar);
    const auto [h, fh] = place(web.horizontal, around);
    const std::size_t rows = web.vertical.size();
    const auto value = [&](std::size_t column, std::size_t row) {
        column = std::min(column, web.horizontal.size() - 1);
        return static_cast<double>(web.values[column * rows + std::min(row, rows - 1)]);
    };
    const double near = value(h, v) * (1 - fv) + value(h, v + 1) * fv;
    const double far = value(h + 1, v) * (1 - fv) + value(h + 1, v + 1) * fv;
    return near * (1 - fh) + far * fh;
}

}  // namespace

V3d emission(const Light& light, const V3d& direction, double squared) {
    const double along = direction.dot(light.direction);
    double share = far_field(light, direction, along, squared) * cone(light, along);
    V3d tint{1, 1, 1};
    if (light.focus > 0) {
        const double focused = along > 0 ? libm::pow(along, static_cast<double>(light.focus)) : 0.0;
        for (int c = 0; c < 3; ++c)
            tint[c] = focused + static_cast<double>(light.focus_tint[c]) * (1 - focused);
    }
    if (light.ies) share *= web(*light.ies, light, direction, along);
    return tint * share;
}

}  // namespace irt
