// SPDX-License-Identifier: Apache-2.0
// The film of a view: beauty and the AOVs asked for, in single precision, row 0 on top.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "irt/film/cause.h"
#include "irt/math/vec.h"
#include "irt/trace/ray.h"

namespace irt::film {

enum class Aov : std::uint8_t {
    Depth,
    Normal,
    Position,
    Albedo,
    ObjectId,
    InstanceId,
    ElementId,
    CryptoObject,
    CryptoMaterial,
    Seen,
    Retraced,
    Cause
};
inline constexpr std::size_t aov_count = 12;

/// The names front ends use, in the order of the enum. Those that begin with `irt.` are not for
/// pictures: the visible point, from which motion is made, and what tells of the update itself.
inline constexpr std::string_view aov_names[aov_count] = {
    "depth",     "normal",       "position",       "albedo",   "objectId",     "instanceId",
    "elementId", "CryptoObject", "CryptoMaterial", "irt.seen", "irt.retraced", "irt.cause"};
std::optional<Aov> aov_named(std::string_view name);

/// Ids where there is nothing to name, as Hydra clears them.
inline constexpr std::uint32_t no_id = 0xffffffffu;

/// An id and the share of the pixel's samples that see it (Cryptomatte 1.2.0).
struct Coverage {
    std::uint32_t id = 0;  ///< cryptomatte_id of the hash of a name
    float share = 0;
};
/// Ids kept of a pixel, the greatest shares first: Cryptomatte's usual depth.
inline constexpr std::size_t most_ranks = 6;
using Ranks = std::array<Coverage, most_ranks>;

/// The visible point of a pixel's first sample.
struct SeenPoint {
    trace::Hit hit;
    V3d position{0, 0, 0};  ///< render space
};

/// What one pixel receives. AOVs are those of its first sample; all zero, and ids none, where it
/// met nothing.
struct PixelValue {
    float rgba[4] = {0, 0, 0,
                     0};    ///< scene-linear; alpha is coverage, colour is premultiplied by it
    float depth = 0;        ///< along the viewing direction, scene units
    V3f normal{0, 0, 0};    ///< world, unit, on the viewer's side
    V3f position{0, 0, 0};  ///< world
    V3f albedo{0, 0, 0};
    std::uint32_t object_id = 0;
    std::uint32_t instance_id = no_id;  ///< key of the instance in its array
    std::uint32_t element_id = no_id;   ///< authored face, curve or point
    SeenPoint seen;
    std::vector<std::array<float, 4>> primvars;  ///< by primvar asked for
    std::vector<V3f> parts;                      ///< by part of the beauty asked for
    Ranks objects, materials;                    ///< of all samples
};

/// Pixels of one image. No AOV takes memory unless asked for (C5).
class Film {
  public:
    /// `primvars` and `parts` (of the beauty): how many are asked for. `samples`: of a pixel, which
    /// bound the ranks.
    Film(int width, int height, const std::vector<Aov>& aovs, std::size_t primvars = 0,
         std::size_t parts = 0, int samples = 1);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] bool has(Aov aov) const { return has_[static_cast<std::size_t>(aov)]; }

    /// Whether an AOV of the first sample's surface was asked for.
    [[nodiscard]] bool shows_surfaces() const { return shows_surfaces_; }
    /// Whether ids of all samples were.
    [[nodiscard]] bool shows_coverage() const {
        return has(Aov::CryptoObject) || has(Aov::CryptoMaterial);
    }
    /// Ranks kept of a pixel: an even number.
    [[nodiscard]] std::size_t ranks() const { return ranks_; }
    [[nodiscard]] std::size_t primvar_count() const { return primvars_.size(); }

    void set(int x, int y, const PixelValue& value);
    /// Where Aov::Retraced was asked for.
    void set_retraced(int x, int y, std::uint64_t rays);
    void clear_retraced();
    /// Red, green and blue, and the parts of the beauty; alpha and other AOVs stand. True if any
    /// bit of the colour is another.
    bool set_color(int x, int y, const V3f& rgb, const std::vector<V3f>& parts);
    /// Where Aov::Cause was asked for.
    void set_cause(int x, int y, CauseCode cause) { causes_[index(x, y)] = cause; }
    void fill_causes(CauseCode cause);

    [[nodiscard]] const float* beauty() const { return beauty_.data(); }
    [[nodiscard]] const float* depth() const { return depth_.data(); }
    [[nodiscard]] const float* retraced() const { return retraced_.data(); }
    [[nodiscard]] const V3f* vectors(Aov aov) const;  ///< Normal, Position or Albedo
    [[nodiscard]] const std::uint32_t* object_id() const { return object_id_.data(); }
    /// ObjectId, InstanceId or ElementId.
    [[nodiscard]] const std::uint32_t* ids(Aov aov) const;
    /// CryptoObject or CryptoMaterial: `ranks()` a pixel.
    [[nodiscard]] const Coverage* coverage(Aov aov) const;
    /// Four floats a pixel.
    [[nodiscard]] const std::array<float, 4>* primvar(std::size_t index) const {
        return primvars_[index].data();
    }
    [[nodiscard]] std::size_t part_count() const { return parts_.size(); }
    [[nodiscard]] const V3f* part(std::size_t index) const { return parts_[index].data(); }
    [[nodiscard]] const SeenPoint* seen() const { return seen_.data(); }
    [[nodiscard]] const CauseCode* causes() const { return causes_.data(); }

    /// For checkpoints (checkpoint/arrays.h): the pixels; which AOVs there are is the maker's.
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self) {
        auto& [width, height, has, shows_surfaces, ranks, beauty, depth, retraced, normal, position,
               albedo, object_id, instance_id, element_id, objects, materials, seen, causes,
               primvars, parts] = self;
        const auto plane = [&](const std::string& what, auto& pixels) {
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
        plane("instance_id", instance_id);
        plane("element_id", element_id);
        plane("objects", objects);
        plane("materials", materials);
        plane("seen", seen);
        plane("causes", causes);
        for (std::size_t p = 0; p < primvars.size(); ++p)
            plane("primvar" + std::to_string(p), primvars[p]);
        for (std::size_t p = 0; p < parts.size(); ++p) plane("part" + std::to_string(p), parts[p]);
    }

  private:
    [[nodiscard]] std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }

    int width_, height_;
    bool has_[aov_count] = {};
    bool shows_surfaces_;
    std::size_t ranks_;
    std::vector<float> beauty_;  ///< RGBA, RGBA, ...
    std::vector<float> depth_, retraced_;
    std::vector<V3f> normal_, position_, albedo_;
    std::vector<std::uint32_t> object_id_, instance_id_, element_id_;
    std::vector<Coverage> objects_, materials_;
    std::vector<SeenPoint> seen_;
    std::vector<CauseCode> causes_;
    std::vector<std::vector<std::array<float, 4>>> primvars_;
    std::vector<std::vector<V3f>> parts_;
};

/// A hash as Cryptomatte keeps it in a float: never a NaN, an infinity or denormal.
[[nodiscard]] constexpr std::uint32_t cryptomatte_id(std::uint32_t hash) {
    const std::uint32_t exponent = hash >> 23 & 0xff;
    return exponent == 0 || exponent == 0xff ? hash ^ 1u << 23 : hash;
}

/// Counts the ids that a pixel's samples see.
class CoverageCount {
  public:
    /// `hash`: of a name.
    void add(std::uint32_t hash);
    /// By falling share, then by id, those of the greatest shares.
    [[nodiscard]] Ranks ranks(int samples);

  private:
    std::vector<std::pair<std::uint32_t, int>> counts_;
};

}  // namespace irt::film
