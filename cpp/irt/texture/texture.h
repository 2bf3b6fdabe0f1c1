// SPDX-License-Identifier: Apache-2.0
// Textures: images as they were decoded, in their file's bit depth, each with a mip pyramid
// (DESIGN 3, rule 12).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "irt/math/vec.h"

namespace irt {

enum class TexelFormat : std::uint8_t { U8, U16, Half, Float };

/// From stored to linear values, of the colour channels; alpha is linear always.
enum class Transfer : std::uint8_t { Linear, Srgb };

/// What lies outside [0, 1]: nothing (0 in every channel), the edge, the image again, or the image
/// mirrored (UsdUVTexture's wrap modes).
enum class Wrap : std::uint8_t { Black, Clamp, Repeat, Mirror };

[[nodiscard]] std::size_t bytes_of(TexelFormat format);

/// Texels row by row, the top row first. Integer formats stand for [0, 1].
struct Image {
    int width = 0, height = 0;
    std::shared_ptr<const std::byte> texels;
};

/// One image of a texture; of a UDIM texture the tile of st in [u, u + 1) x [v, v + 1).
struct Tile {
    int u = 0, v = 0;
    int channels = 4;  ///< 1 to 4: grey; grey, alpha; rgb; rgb, alpha
    TexelFormat format = TexelFormat::U8;
    std::vector<Image> levels;  ///< finest first; each half the size of the one before
};

class Texture {
  public:
    /// `tiles` have one level each; the coarser ones are made here: means over areas, in linear
    /// light, rounded to the tile's format. `rendering_from_image` takes linear RGB, as a column,
    /// to the rendering space, row by row. Throws std::invalid_argument on sizes or channels that
    /// are none, on two tiles at a place, on no tile.
    Texture(std::vector<Tile> tiles, Transfer transfer,
            const std::array<double, 9>& rendering_from_image, bool udim);

    /// Without its `count` finest levels, or with its coarsest alone. Levels are shared.
    [[nodiscard]] Texture without_finest(std::size_t count) const;
    /// Bytes of all tiles' texels, level by level, the finest first.
    [[nodiscard]] std::vector<std::size_t> level_bytes() const;

    [[nodiscard]] const std::vector<Tile>& tiles() const { return tiles_; }
    [[nodiscard]] Transfer transfer() const { return transfer_; }
    [[nodiscard]] bool udim() const { return udim_; }
    /// The tile that `st` lies in, or null.
    [[nodiscard]] const Tile* tile_at(const V2d& st) const;
    [[nodiscard]] V3d to_rendering_space(const V3d& rgb) const;

    friend bool same(const Texture& a, const Texture& b);

  private:
    std::vector<Tile> tiles_;  ///< by v, then u
    Transfer transfer_;
    std::array<double, 9> matrix_;
    bool has_matrix_;  ///< other than the identity
    bool udim_;
};

/// Whether two textures give the same values: compared byte by byte unless they share them.
bool same(const Texture& a, const Texture& b);

}  // namespace irt
