// SPDX-License-Identifier: Apache-2.0
#include "irt/texture/rows.h"

#include "irt/math/float_state.h"
#include "irt/texture/texel.h"

namespace irt::texture {

std::vector<V3d> row_of(const Texture& texture, const Tile& tile, int row) {
    const Image& image = tile.levels.front();
    const auto width = static_cast<std::size_t>(image.width);
    const auto channels = static_cast<std::size_t>(tile.channels);
    std::vector<V3d> colors(width);
    with_format(tile.format, [&]<TexelFormat format>() {
        const std::size_t size = bytes_of(format);
        const std::byte* at =
            image.texels.get() + static_cast<std::size_t>(row) * width * channels * size;
        for (V3d& color : colors) {
            for (std::size_t c = 0; c < 3; ++c)
                color[static_cast<int>(c)] =
                    decode<format>(at + (channels < 3 ? 0 : c) * size, texture.transfer());
            color = texture.to_rendering_space(color);
            at += channels * size;
        }
    });
    return colors;
}

V3d mean(const Texture& texture) {
    const FloatState ieee;
    V3d sum{0, 0, 0};
    for (const Tile& tile : texture.tiles()) {
        const Image& image = tile.levels.front();
        V3d of_tile{0, 0, 0};
        for (int row = 0; row < image.height; ++row)
            for (const V3d& color : row_of(texture, tile, row)) of_tile += color;
        sum += of_tile / (static_cast<double>(image.width) * image.height);
    }
    return sum / static_cast<double>(texture.tiles().size());
}

}  // namespace irt::texture
