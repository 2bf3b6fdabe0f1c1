// SPDX-License-Identifier: Apache-2.0
#include "irt/film/film.h"

#include <algorithm>

namespace irt::film {

std::optional<Aov> aov_named(std::string_view name) {
    const auto* found = std::find(std::begin(aov_names), std::end(aov_names), name);
    if (found == std::end(aov_names)) return std::nullopt;
    return static_cast<Aov>(found - std::begin(aov_names));
}

Film::Film(int width, int height, const std::vector<Aov>& aovs)
    : width_(width),
      height_(height),
      shows_surfaces_(
          std::any_of(aovs.begin(), aovs.end(), [](Aov aov) { return aov != Aov::Retraced; })) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (const Aov aov : aovs) has_[static_cast<std::size_t>(aov)] = true;
    beauty_.resize(pixels * 4);
    if (has(Aov::Depth)) depth_.resize(pixels);
    if (has(Aov::Normal)) normal_.resize(pixels, V3f(0, 0, 0));
    if (has(Aov::Position)) position_.resize(pixels, V3f(0, 0, 0));
    if (has(Aov::Albedo)) albedo_.resize(pixels, V3f(0, 0, 0));
    if (has(Aov::ObjectId)) object_id_.resize(pixels);
    if (has(Aov::Retraced)) retraced_.resize(pixels);
}

void Film::set(int x, int y, const PixelValue& value) {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x);
    std::copy(std::begin(value.rgba), std::end(value.rgba), &beauty_[4 * i]);
    if (!shows_surfaces_) return;
    if (has(Aov::Depth)) depth_[i] = value.depth;
    if (has(Aov::Normal)) normal_[i] = value.normal;
    if (has(Aov::Position)) position_[i] = value.position;
    if (has(Aov::Albedo)) albedo_[i] = value.albedo;
    if (has(Aov::ObjectId)) object_id_[i] = value.object_id;
}

void Film::set_retraced(int x, int y, std::uint64_t rays) {
    retraced_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
              static_cast<std::size_t>(x)] = static_cast<float>(rays);
}

void Film::clear_retraced() { std::fill(retraced_.begin(), retraced_.end(), 0.0f); }

void Film::set_color(int x, int y, const V3f& rgb) {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x);
    for (int c = 0; c < 3; ++c) beauty_[4 * i + static_cast<std::size_t>(c)] = rgb[c];
}

const V3f* Film::vectors(Aov aov) const {
    switch (aov) {
        case Aov::Normal:
            return normal_.data();
        case Aov::Position:
            return position_.data();
        default:
            return albedo_.data();
    }
}

}  // namespace irt::film
