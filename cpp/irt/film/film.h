// SPDX-License-Identifier: Apache-2.0
// The film of a view: beauty and the AOVs asked for, in single precision, row 0 on top.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "irt/math/vec.h"

namespace irt::film {

enum class Aov : std::uint8_t { Depth, Normal, Position, Albedo, ObjectId, Retraced };
inline constexpr std::size_t aov_count = 6;

/// The names front ends use, in the order of the enum. Those that begin with `irt.` tell of the
/// update itself: rays retraced in it.
inline constexpr std::string_view aov_names[aov_count] = {"depth",  "normal",   "position",
                                                          "albedo", "objectId", "irt.retraced"};
std::optional<Aov> aov_named(std::string_view name);

/// What one pixel receives. AOVs are those of its first sample; all zero where it met nothing.
struct PixelValue {
    float rgba[4] = {0, 0, 0,
                     0};    ///< scene-linear; alpha is coverage, colour is premultiplied by it
    float depth = 0;        ///< along the viewing direction, scene units
    V3f normal{0, 0, 0};    ///< world, unit, on the viewer's side
    V3f position{0, 0, 0};  ///< world
    V3f albedo{0, 0, 0};
    std::uint32_t object_id = 0;
};

/// Pixels of one image. No AOV takes memory unless asked for (C5).
class Film {
  public:
    Film(int width, int height, const std::vector<Aov>& aovs);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] bool has(Aov aov) const { return has_[static_cast<std::size_t>(aov)]; }

    /// Whether an AOV of what is seen was asked for.
    [[nodiscard]] bool shows_surfaces() const { return shows_surfaces_; }

    void set(int x, int y, const PixelValue& value);
    /// Where Aov::Retraced was asked for.
    void set_retraced(int x, int y, std::uint64_t rays);
    void clear_retraced();
    /// Red, green and blue; alpha and AOVs stand.
    void set_color(int x, int y, const V3f& rgb);

    [[nodiscard]] const float* beauty() const { return beauty_.data(); }
    [[nodiscard]] const float* depth() const { return depth_.data(); }
    [[nodiscard]] const float* retraced() const { return retraced_.data(); }
    [[nodiscard]] const V3f* vectors(Aov aov) const;  ///< Normal, Position or Albedo
    [[nodiscard]] const std::uint32_t* object_id() const { return object_id_.data(); }

    /// For checkpoints (checkpoint/arrays.h): the pixels; which AOVs there are is the maker's.
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self) {
        auto& [width, height, has, shows_surfaces, beauty, depth, retraced, normal, position,
               albedo, object_id] = self;
        const auto plane = [&](const char* what, auto& pixels) {
            const std::size_t size = pixels.size();
            to.array(name + what, pixels);
            if (pixels.size() != size)
                throw std::runtime_error(name + what + ": is of another film");
        };
        plane("beauty", beauty);
        plane("depth", depth);
        plane("retraced", retraced);
        plane("normal", normal);
        plane("position", position);
        plane("albedo", albedo);
        plane("object_id", object_id);
    }

  private:
    int width_, height_;
    bool has_[aov_count] = {};
    bool shows_surfaces_;
    std::vector<float> beauty_;  ///< RGBA, RGBA, ...
    std::vector<float> depth_, retraced_;
    std::vector<V3f> normal_, position_, albedo_;
    std::vector<std::uint32_t> object_id_;
};

}  // namespace irt::film
