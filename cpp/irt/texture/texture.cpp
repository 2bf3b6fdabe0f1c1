// SPDX-License-Identifier: Apache-2.0
#include "irt/texture/texture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "irt/math/bits.h"
#include "irt/math/float_state.h"
#include "irt/texture/pyramid.h"

namespace irt {

namespace {

constexpr std::array<double, 9> identity{1, 0, 0, 0, 1, 0, 0, 0, 1};

std::size_t image_bytes(const Tile& tile, const Image& image) {
    return static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
           static_cast<std::size_t>(tile.channels) * bytes_of(tile.format);
}

bool same(const Tile& a, const Tile& b) {
    if (a.u != b.u || a.v != b.v || a.channels != b.channels || a.format != b.format ||
        a.levels.size() != b.levels.size())
        return false;
    const Image &x = a.levels.front(), &y = b.levels.front();
    return x.width == y.width && x.height == y.height &&
           (x.texels == y.texels ||
            std::memcmp(x.texels.get(), y.texels.get(), image_bytes(a, x)) == 0);
}

}  // namespace

std::size_t bytes_of(TexelFormat format) {
    switch (format) {
        case TexelFormat::U8:
            return 1;
        case TexelFormat::U16:
        case TexelFormat::Half:
            return 2;
        case TexelFormat::Float:
            break;
    }
    return 4;
}

Texture::Texture(std::vector<Tile> tiles, Transfer transfer,
                 const std::array<double, 9>& rendering_from_image, bool udim)
    : tiles_(std::move(tiles)),
      transfer_(transfer),
      matrix_(rendering_from_image),
      has_matrix_(matrix_ != identity),
      udim_(udim) {
    const FloatState ieee;
    if (tiles_.empty()) throw std::invalid_argument("a texture needs a tile");
    const auto place = [](const Tile& t) { return std::pair(t.v, t.u); };
    std::sort(tiles_.begin(), tiles_.end(),
              [&](const Tile& a, const Tile& b) { return place(a) < place(b); });
    for (std::size_t i = 1; i < tiles_.size(); ++i)
        if (!udim || place(tiles_[i]) == place(tiles_[i - 1]))
            throw std::invalid_argument(udim ? "two tiles of a texture at one place"
                                             : "a texture that is no UDIM has one tile");
    for (const double m : matrix_)
        if (!std::isfinite(m)) throw std::invalid_argument("a texture's matrix is not finite");
    for (Tile& tile : tiles_) {
        if (tile.levels.size() != 1 || tile.levels[0].width < 1 || tile.levels[0].height < 1)
            throw std::invalid_argument("a texture's image is empty");
        if (tile.channels < 1 || tile.channels > 4)
            throw std::invalid_argument("a texture's image must have 1 to 4 channels");
        while (tile.levels.back().width > 1 || tile.levels.back().height > 1)
            tile.levels.push_back(
                texture::halved(tile.levels.back(), tile.channels, tile.format, transfer_));
    }
}

Texture Texture::without_finest(std::size_t count) const {
    Texture out = *this;
    for (Tile& tile : out.tiles_) {
        const std::size_t gone = std::min(count, tile.levels.size() - 1);
        tile.levels.erase(tile.levels.begin(),
                          tile.levels.begin() + static_cast<std::ptrdiff_t>(gone));
    }
    return out;
}

std::vector<std::size_t> Texture::level_bytes() const {
    std::vector<std::size_t> bytes;
    for (const Tile& tile : tiles_) {
        bytes.resize(std::max(bytes.size(), tile.levels.size()));
        for (std::size_t l = 0; l < tile.levels.size(); ++l)
            bytes[l] += image_bytes(tile, tile.levels[l]);
    }
    return bytes;
}

const Tile* Texture::tile_at(const V2d& st) const {
    if (!udim_) return &tiles_.front();
    const double u = std::floor(st.x), v = std::floor(st.y);
    const auto found = std::find_if(tiles_.begin(), tiles_.end(),
                                    [&](const Tile& t) { return t.u == u && t.v == v; });
    return found == tiles_.end() ? nullptr : &*found;
}

V3d Texture::to_rendering_space(const V3d& rgb) const {
    if (!has_matrix_) return rgb;
    const auto row = [&](std::size_t r) {
        return matrix_[r] * rgb.x + matrix_[r + 1] * rgb.y + matrix_[r + 2] * rgb.z;
    };
    return {row(0), row(3), row(6)};
}

bool same(const Texture& a, const Texture& b) {
    return a.transfer_ == b.transfer_ && a.udim_ == b.udim_ && same_bits(a.matrix_, b.matrix_) &&
           std::equal(a.tiles_.begin(), a.tiles_.end(), b.tiles_.begin(), b.tiles_.end(),
                      [](const Tile& x, const Tile& y) { return same(x, y); });
}

}  // namespace irt
