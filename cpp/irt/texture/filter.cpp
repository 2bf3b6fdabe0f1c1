// SPDX-License-Identifier: Apache-2.0
#include "irt/texture/filter.h"

#include <algorithm>
#include <cmath>

#include "irt/texture/texel.h"

namespace irt::texture {

namespace {

/// How the footprint is probed in a tile: along `axis` (st), `count` times, at level `lod`.
struct Probes {
    V2d axis;
    int count;
    double lod;
};

/// The longer axis of the ellipse that maps the unit circle by the columns (dx, dy), and both
/// lengths (singular values; the longer axis is the eigenvector of M M^T).
struct Ellipse {
    V2d major;
    double longer, shorter;
};

Ellipse ellipse(const V2d& dx, const V2d& dy) {
    const double a = dx.x * dx.x + dy.x * dy.x, b = dx.x * dx.y + dy.x * dy.y,
                 c = dx.y * dx.y + dy.y * dy.y;
    const double mean = 0.5 * (a + c), half = 0.5 * (a - c);
    const double root = std::sqrt(half * half + b * b);
    // Of the two forms of the eigenvector, the one that does not cancel.
    V2d major = half >= 0 ? V2d(half + root, b) : V2d(b, root - half);
    const double size = std::sqrt(major.x * major.x + major.y * major.y);
    major = size > 0 ? V2d(major.x / size, major.y / size) : V2d(1, 0);
    return {major, std::sqrt(mean + root), std::sqrt(std::max(mean - root, 0.0))};
}

Probes probes(const Tile& tile, const V2d& dx, const V2d& dy) {
    const Image& finest = tile.levels.front();
    const double w = finest.width, h = finest.height;
    const Ellipse e = ellipse({dx.x * w, dx.y * h}, {dy.x * w, dy.y * h});
    if (!(e.longer > 1)) return {{0, 0}, 1, 0};  // magnified
    const double ratio = std::ceil(e.longer / std::max(e.shorter, 1.0));
    const int count = ratio < max_probes ? static_cast<int>(ratio) : max_probes;
    const double last = static_cast<double>(tile.levels.size() - 1);
    const double lod = libm::log2(std::max(e.longer / count, 1.0));
    return {{e.major.x * e.longer / w, e.major.y * e.longer / h}, count, lod < last ? lod : last};
}

/// The texel that index `i` of `n` stands for, or -1 for none.
int wrapped(int i, int n, Wrap wrap) {
    switch (wrap) {
        case Wrap::Black:
            return i < 0 || i >= n ? -1 : i;
        case Wrap::Clamp:
            return std::clamp(i, 0, n - 1);
        case Wrap::Repeat:
            return i < 0 ? i + n : (i >= n ? i - n : i);
        case Wrap::Mirror:
            break;
    }
    const int period = 2 * n, k = i < 0 ? i + period : (i >= period ? i - period : i);
    return k < n ? k : period - 1 - k;
}

/// `s`, brought near the image where every wrap mode has seen all it can show.
double reduced(double s, Wrap wrap) {
    switch (wrap) {
        case Wrap::Black:
        case Wrap::Clamp:
            return std::clamp(s, -1.0, 2.0);
        case Wrap::Repeat:
            return s - std::floor(s);
        case Wrap::Mirror:
            break;
    }
    return s - 2 * std::floor(0.5 * s);
}

/// The two texels on either side of a coordinate, and the share of the second.
struct Pair {
    int texel[2];
    double share;
};

Pair neighbours(double s, int n, Wrap wrap) {
    const double x = s * n - 0.5, below = std::floor(x);
    const int i = static_cast<int>(below);
    return {{wrapped(i, n, wrap), wrapped(i + 1, n, wrap)}, x - below};
}

/// Between the four nearest texels of a level; `s` and `t` reduced.
template <TexelFormat format>
Texel bilinear(const Tile& tile, const Image& image, Transfer transfer, double s, double t,
               Wrap wrap_s, Wrap wrap_t) {
    const Pair x = neighbours(s, image.width, wrap_s), y = neighbours(t, image.height, wrap_t);
    const std::size_t size = bytes_of(format),
                      texel = static_cast<std::size_t>(tile.channels) * size;
    Texel sum{};
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            if (x.texel[i] < 0 || y.texel[j] < 0) continue;
            const double weight = (i ? x.share : 1 - x.share) * (j ? y.share : 1 - y.share);
            if (weight == 0) continue;
            // The first row is the top one, where t is 1.
            const auto row = static_cast<std::size_t>(image.height - 1 - y.texel[j]),
                       width = static_cast<std::size_t>(image.width),
                       column = static_cast<std::size_t>(x.texel[i]);
            const std::byte* at = image.texels.get() + (row * width + column) * texel;
            for (int c = 0; c < tile.channels; ++c)
                sum[static_cast<std::size_t>(c)] +=
                    weight *
                    decode<format>(at + static_cast<std::size_t>(c) * size,
                                   is_color(c, tile.channels) ? transfer : Transfer::Linear);
        }
    return sum;
}

Texel trilinear(const Tile& tile, Transfer transfer, double lod, const V2d& st, Wrap wrap_s,
                Wrap wrap_t) {
    const double s = reduced(st.x, wrap_s), t = reduced(st.y, wrap_t);
    const auto level = static_cast<std::size_t>(lod);
    const double share = lod - static_cast<double>(level);
    return with_format(tile.format, [&]<TexelFormat format>() {
        Texel value = bilinear<format>(tile, tile.levels[level], transfer, s, t, wrap_s, wrap_t);
        if (share > 0) {
            const Texel coarser =
                bilinear<format>(tile, tile.levels[level + 1], transfer, s, t, wrap_s, wrap_t);
            for (std::size_t c = 0; c < 4; ++c) value[c] += (coarser[c] - value[c]) * share;
        }
        return value;
    });
}

/// UsdUVTexture: one channel gives (r, r, r, 1), two (r, r, r, g), three (r, g, b, 1).
Texel four_channels(const Texel& value, int channels) {
    if (channels == 1) return {value[0], value[0], value[0], 1};
    if (channels == 2) return {value[0], value[0], value[0], value[1]};
    if (channels == 3) return {value[0], value[1], value[2], 1};
    return value;
}

}  // namespace

std::optional<Texel> look_up(const Texture& texture, Wrap wrap_s, Wrap wrap_t, const V2d& st,
                             const V2d& dx, const V2d& dy) {
    if (!std::isfinite(st.x) || !std::isfinite(st.y)) return std::nullopt;
    const Tile* const centre = texture.tile_at(st);
    if (!centre) return std::nullopt;
    const Probes along = probes(*centre, dx, dy);
    Texel sum{};
    int found = 0;
    for (int i = 0; i < along.count; ++i) {
        V2d at = st;
        if (along.count > 1) at += along.axis * ((i + 0.5) / along.count - 0.5);
        const Tile* tile = centre;
        double lod = along.lod;
        if (texture.udim()) {
            tile = texture.tile_at(at);
            if (!tile) continue;  // the mean of what is there
            if (tile != centre) lod = probes(*tile, dx, dy).lod;
            at -= V2d(tile->u, tile->v);
        }
        const Texel value = four_channels(
            trilinear(*tile, texture.transfer(), lod, at, texture.udim() ? Wrap::Clamp : wrap_s,
                      texture.udim() ? Wrap::Clamp : wrap_t),
            tile->channels);
        for (std::size_t c = 0; c < 4; ++c) sum[c] += value[c];
        ++found;
    }
    if (found == 0) return std::nullopt;
    if (found > 1)
        for (double& c : sum) c /= found;
    const V3d rgb = texture.to_rendering_space({sum[0], sum[1], sum[2]});
    return Texel{rgb.x, rgb.y, rgb.z, sum[3]};
}

}  // namespace irt::texture
