// SPDX-License-Identifier: Apache-2.0
#include "irt/film/film.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace irt::film {

std::optional<Aov> aov_named(std::string_view name) {
    const auto* found = std::find(std::begin(aov_names), std::end(aov_names), name);
    if (found == std::end(aov_names)) return std::nullopt;
    return static_cast<Aov>(found - std::begin(aov_names));
}

Film::Film(int width, int height, const std::vector<Aov>& aovs, std::size_t primvars,
           std::size_t parts, int samples)
    : width_(width),
      height_(height),
      shows_surfaces_(primvars > 0 || std::any_of(aovs.begin(), aovs.end(),
                                                  [](Aov aov) {
                                                      return aov != Aov::Retraced &&
                                                             aov != Aov::Cause &&
                                                             aov != Aov::CryptoObject &&
                                                             aov != Aov::CryptoMaterial;
                                                  })),
      ranks_(std::min((static_cast<std::size_t>(samples) + 1) / 2 * 2, most_ranks)) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (const Aov aov : aovs) has_[static_cast<std::size_t>(aov)] = true;
    beauty_.resize(pixels * 4);
    if (has(Aov::Depth)) depth_.resize(pixels);
    if (has(Aov::Normal)) normal_.resize(pixels, V3f(0, 0, 0));
    if (has(Aov::Position)) position_.resize(pixels, V3f(0, 0, 0));
    if (has(Aov::Albedo)) albedo_.resize(pixels, V3f(0, 0, 0));
    if (has(Aov::ObjectId)) object_id_.resize(pixels);
    if (has(Aov::InstanceId)) instance_id_.resize(pixels, no_id);
    if (has(Aov::ElementId)) element_id_.resize(pixels, no_id);
    if (has(Aov::CryptoObject)) objects_.resize(pixels * ranks_);
    if (has(Aov::CryptoMaterial)) materials_.resize(pixels * ranks_);
    if (has(Aov::Seen)) seen_.resize(pixels);
    if (has(Aov::Cause)) causes_.resize(pixels);
    if (has(Aov::Retraced)) retraced_.resize(pixels);
    primvars_.assign(primvars, std::vector<std::array<float, 4>>(pixels));
    parts_.assign(parts, std::vector<V3f>(pixels, V3f(0, 0, 0)));
}

void Film::set(int x, int y, const PixelValue& value) {
    const std::size_t i = index(x, y);
    std::copy(std::begin(value.rgba), std::end(value.rgba), &beauty_[4 * i]);
    if (has(Aov::CryptoObject)) std::copy_n(value.objects.begin(), ranks_, &objects_[ranks_ * i]);
    if (has(Aov::CryptoMaterial))
        std::copy_n(value.materials.begin(), ranks_, &materials_[ranks_ * i]);
    for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p][i] = value.parts[p];
    if (!shows_surfaces_) return;
    if (has(Aov::Depth)) depth_[i] = value.depth;
    if (has(Aov::Normal)) normal_[i] = value.normal;
    if (has(Aov::Position)) position_[i] = value.position;
    if (has(Aov::Albedo)) albedo_[i] = value.albedo;
    if (has(Aov::ObjectId)) object_id_[i] = value.object_id;
    if (has(Aov::InstanceId)) instance_id_[i] = value.instance_id;
    if (has(Aov::ElementId)) element_id_[i] = value.element_id;
    if (has(Aov::Seen)) seen_[i] = value.seen;
    for (std::size_t p = 0; p < primvars_.size(); ++p)
        primvars_[p][i] = p < value.primvars.size() ? value.primvars[p] : std::array<float, 4>{};
}

void Film::set_retraced(int x, int y, std::uint64_t rays) {
    retraced_[index(x, y)] = static_cast<float>(rays);
}

void Film::clear_retraced() { std::fill(retraced_.begin(), retraced_.end(), 0.0f); }

bool Film::set_color(int x, int y, const V3f& rgb, const std::vector<V3f>& parts) {
    const std::size_t i = index(x, y);
    float* const color = &beauty_[4 * i];
    const bool changed = std::memcmp(color, &rgb.x, 3 * sizeof(float)) != 0;
    for (int c = 0; c < 3; ++c) color[c] = rgb[c];
    for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p][i] = parts[p];
    return changed;
}

void Film::fill_causes(CauseCode cause) { std::fill(causes_.begin(), causes_.end(), cause); }

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

const std::uint32_t* Film::ids(Aov aov) const {
    switch (aov) {
        case Aov::InstanceId:
            return instance_id_.data();
        case Aov::ElementId:
            return element_id_.data();
        default:
            return object_id_.data();
    }
}

const Coverage* Film::coverage(Aov aov) const {
    return aov == Aov::CryptoObject ? objects_.data() : materials_.data();
}

void CoverageCount::add(std::uint32_t hash) {
    const std::uint32_t id = cryptomatte_id(hash);
    const auto found = std::find_if(counts_.begin(), counts_.end(),
                                    [id](const auto& counted) { return counted.first == id; });
    if (found == counts_.end())
        counts_.emplace_back(id, 1);
    else
        ++found->second;
}

Ranks CoverageCount::ranks(int samples) {
    std::sort(counts_.begin(), counts_.end(), [](const auto& a, const auto& b) {
        return std::tuple(-a.second, a.first) < std::tuple(-b.second, b.first);
    });
    Ranks ranks{};
    for (std::size_t r = 0; r < std::min(counts_.size(), most_ranks); ++r)
        ranks[r] = {counts_[r].first,
                    static_cast<float>(static_cast<double>(counts_[r].second) / samples)};
    return ranks;
}

}  // namespace irt::film
