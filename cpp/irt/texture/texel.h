// SPDX-License-Identifier: Apache-2.0
// Between stored texels and linear values.
#pragma once

#include <Imath/half.h>

#include <array>
#include <cstring>

#include "irt/math/libm.h"
#include "irt/texture/texture.h"

namespace irt::texture {

/// IEC 61966-2-1; what lies outside [0, 1] goes on by the same formula.
inline double srgb_to_linear(double v) {
    return v <= 0.04045 ? v / 12.92 : libm::pow((v + 0.055) / 1.055, 2.4);
}
inline double linear_to_srgb(double v) {
    return v <= 0.0031308 ? v * 12.92 : 1.055 * libm::pow(v, 1 / 2.4) - 0.055;
}

/// Linear values of the 256 or 65536 codes of sRGB.
const std::array<double, 256>& srgb_codes_8();
const std::vector<double>& srgb_codes_16();

/// One channel of one texel, decoded.
template <TexelFormat format>
inline double decode(const std::byte* at, Transfer transfer) {
    if constexpr (format == TexelFormat::U8) {
        const auto code = static_cast<std::uint8_t>(*at);
        return transfer == Transfer::Srgb ? srgb_codes_8()[code] : code / 255.0;
    } else if constexpr (format == TexelFormat::U16) {
        std::uint16_t code;
        std::memcpy(&code, at, sizeof code);
        return transfer == Transfer::Srgb ? srgb_codes_16()[code] : code / 65535.0;
    } else if constexpr (format == TexelFormat::Half) {
        half value;
        std::memcpy(static_cast<void*>(&value), at, sizeof value);
        const auto wide = static_cast<double>(static_cast<float>(value));
        return transfer == Transfer::Srgb ? srgb_to_linear(wide) : wide;
    } else {
        float value;
        std::memcpy(&value, at, sizeof value);
        const auto wide = static_cast<double>(value);
        return transfer == Transfer::Srgb ? srgb_to_linear(wide) : wide;
    }
}

/// Whether channel `c` of `channels` is colour, not alpha.
inline bool is_color(int c, int channels) { return c < (channels < 3 ? 1 : 3); }

/// Calls body<format>().
template <class Body>
decltype(auto) with_format(TexelFormat format, Body&& body) {
    switch (format) {
        case TexelFormat::U8:
            return body.template operator()<TexelFormat::U8>();
        case TexelFormat::U16:
            return body.template operator()<TexelFormat::U16>();
        case TexelFormat::Half:
            return body.template operator()<TexelFormat::Half>();
        case TexelFormat::Float:
            break;
    }
    return body.template operator()<TexelFormat::Float>();
}

}  // namespace irt::texture
