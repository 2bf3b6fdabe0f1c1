// SPDX-License-Identifier: Apache-2.0
#include "irt/texture/pyramid.h"

#include <algorithm>
#include <cmath>

#include "irt/texture/texel.h"

namespace irt::texture {

namespace {

/// The source texels that one texel of the next level covers, with the share of each.
struct Span {
    int first = 0, count = 0;
    std::array<double, 3> weight{};
};

/// Along one axis, from `from` texels to `to` (half of them, rounded down, or 1).
std::vector<Span> spans(int from, int to) {
    std::vector<Span> out(static_cast<std::size_t>(to));
    const double scale = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        Span& span = out[static_cast<std::size_t>(i)];
        const double begin = i * scale, end = i + 1 == to ? from : (i + 1) * scale;
        span.first = static_cast<int>(begin);
        for (int k = span.first; k < from && k < end; ++k) {
            const double covered = std::min<double>(k + 1, end) - std::max<double>(k, begin);
            span.weight[static_cast<std::size_t>(span.count++)] = covered / scale;
        }
    }
    return out;
}

/// The nearest code of sRGB, by the values half-way between codes; a table of the first code that
/// each 4096th of the range may have finds it in a few steps.
class SrgbEncoder {
  public:
    SrgbEncoder() {
        for (int i = 0; i < 255; ++i)
            upper_[static_cast<std::size_t>(i)] = srgb_to_linear((i + 0.5) / 255);
        upper_[255] = std::numeric_limits<double>::infinity();
        std::uint8_t code = 0;
        for (std::size_t i = 0; i < first_.size(); ++i) {
            while (upper_[code] <= static_cast<double>(i) / steps) ++code;
            first_[i] = code;
        }
    }
    [[nodiscard]] std::uint8_t operator()(double linear) const {
        const double bounded = linear >= 0 ? std::min(linear, 1.0) : 0.0;
        std::uint8_t code = first_[static_cast<std::size_t>(bounded * steps)];
        while (upper_[code] <= bounded) ++code;
        return code;
    }

  private:
    static constexpr int steps = 4096;
    std::array<double, 256> upper_{};  ///< from here on the next code is nearer
    std::array<std::uint8_t, steps + 1> first_{};
};

double code_of(double value, double codes) {
    return std::floor((value >= 0 ? std::min(value, 1.0) : 0.0) * codes + 0.5);
}

template <TexelFormat format>
void encode(double linear, Transfer transfer, std::byte* at) {
    if constexpr (format == TexelFormat::U8) {
        static const SrgbEncoder srgb;
        *at = static_cast<std::byte>(transfer == Transfer::Srgb
                                         ? srgb(linear)
                                         : static_cast<std::uint8_t>(code_of(linear, 255)));
    } else {
        const double stored = transfer == Transfer::Srgb ? linear_to_srgb(linear) : linear;
        if constexpr (format == TexelFormat::U16) {
            const auto code = static_cast<std::uint16_t>(code_of(stored, 65535));
            std::memcpy(at, &code, sizeof code);
        } else if constexpr (format == TexelFormat::Half) {
            const half value(static_cast<float>(stored));
            std::memcpy(at, &value, sizeof value);
        } else {
            const auto value = static_cast<float>(stored);
            std::memcpy(at, &value, sizeof value);
        }
    }
}

template <TexelFormat format>
void halve(const Image& image, int channels, Transfer transfer, const Image& to,
           std::byte* texels) {
    const std::vector<Span> columns = spans(image.width, to.width),
                            rows = spans(image.height, to.height);
    const std::size_t size = bytes_of(format), texel = static_cast<std::size_t>(channels) * size,
                      row = static_cast<std::size_t>(image.width) * texel;
    for (const Span& y : rows)
        for (const Span& x : columns)
            for (int c = 0; c < channels; ++c) {
                const Transfer of = is_color(c, channels) ? transfer : Transfer::Linear;
                const std::byte* corner =
                    image.texels.get() + static_cast<std::size_t>(y.first) * row +
                    static_cast<std::size_t>(x.first) * texel + static_cast<std::size_t>(c) * size;
                double sum = 0;
                for (std::size_t j = 0; j < static_cast<std::size_t>(y.count); ++j) {
                    double line = 0;
                    for (std::size_t i = 0; i < static_cast<std::size_t>(x.count); ++i)
                        line += x.weight[i] * decode<format>(corner + j * row + i * texel, of);
                    sum += y.weight[j] * line;
                }
                encode<format>(sum, of, texels);
                texels += size;
            }
}

}  // namespace

Image halved(const Image& image, int channels, TexelFormat format, Transfer transfer) {
    Image out;
    out.width = std::max(image.width / 2, 1);
    out.height = std::max(image.height / 2, 1);
    const std::size_t bytes = static_cast<std::size_t>(out.width) *
                              static_cast<std::size_t>(out.height) *
                              static_cast<std::size_t>(channels) * bytes_of(format);
    const std::shared_ptr<std::byte[]> texels(new std::byte[bytes]);
    with_format(format,
                [&]<TexelFormat f>() { halve<f>(image, channels, transfer, out, texels.get()); });
    out.texels = std::shared_ptr<const std::byte>(texels, texels.get());
    return out;
}

const std::array<double, 256>& srgb_codes_8() {
    static const std::array<double, 256> table = [] {
        std::array<double, 256> out{};
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = srgb_to_linear(static_cast<double>(i) / 255);
        return out;
    }();
    return table;
}

const std::vector<double>& srgb_codes_16() {
    static const std::vector<double> table = [] {
        std::vector<double> out(65536);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = srgb_to_linear(static_cast<double>(i) / 65535);
        return out;
    }();
    return table;
}

}  // namespace irt::texture
