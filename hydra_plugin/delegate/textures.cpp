// SPDX-License-Identifier: Apache-2.0
#include "delegate/textures.h"

#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <vector>

#include "pxr/base/gf/half.h"
#include "pxr/base/tf/diagnostic.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/imaging/hio/image.h"
#include "pxr/usd/ar/resolver.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr int firstTile = 1001, lastTile = 1100;
const std::string udimPattern = "<UDIM>";

struct Decoded {
    irt::Tile tile;
    irt::Wrap wrap_s, wrap_t;
};

irt::Wrap WrapOf(const HioImage& image, HioAddressDimension dimension) {
    HioAddressMode mode;
    if (!image.GetSamplerMetadata(dimension, &mode)) return irt::Wrap::Black;
    switch (mode) {
        case HioAddressModeClampToEdge:
            return irt::Wrap::Clamp;
        case HioAddressModeRepeat:
            return irt::Wrap::Repeat;
        case HioAddressModeMirrorRepeat:
            return irt::Wrap::Mirror;
        default:
            return irt::Wrap::Black;
    }
}

irt::Wrap Named(const std::string& name, irt::Wrap otherwise) {
    if (name == "black") return irt::Wrap::Black;
    if (name == "clamp") return irt::Wrap::Clamp;
    if (name == "repeat") return irt::Wrap::Repeat;
    if (name == "mirror") return irt::Wrap::Mirror;
    return otherwise;
}

/// What the core keeps of a format; empty: it cannot.
std::optional<irt::TexelFormat> FormatOf(HioFormat format) {
    switch (HioGetHioType(format)) {
        case HioTypeUnsignedByte:
        case HioTypeUnsignedByteSRGB:
            return irt::TexelFormat::U8;
        case HioTypeUnsignedShort:
            return irt::TexelFormat::U16;
        case HioTypeHalfFloat:
            return irt::TexelFormat::Half;
        case HioTypeFloat:
            return irt::TexelFormat::Float;
        default:
            return std::nullopt;
    }
}

/// Numbers that are none become 0.
void MendFloats(irt::TexelFormat format, std::byte* data, std::size_t bytes) {
    if (format == irt::TexelFormat::Float) {
        for (std::size_t i = 0; i + 4 <= bytes; i += 4) {
            float value;
            std::memcpy(&value, data + i, 4);
            if (std::isnan(value)) std::memset(data + i, 0, 4);
        }
    } else if (format == irt::TexelFormat::Half) {
        for (std::size_t i = 0; i + 2 <= bytes; i += 2) {
            std::uint16_t bits;
            std::memcpy(&bits, data + i, 2);
            if ((bits & 0x7c00) == 0x7c00 && (bits & 0x3ff) != 0) std::memset(data + i, 0, 2);
        }
    }
}

std::optional<Decoded> Decode(const std::string& file, std::string& fault) {
    const HioImageSharedPtr image = HioImage::OpenForReading(file, 0, 0, HioImage::Raw, true);
    if (!image) {
        fault = "no such file, or no image that Hio reads";
        return std::nullopt;
    }
    const HioFormat format = image->GetFormat();
    const std::optional<irt::TexelFormat> texels = FormatOf(format);
    const int channels = HioGetComponentCount(format);
    if (!texels || channels < 1 || channels > 4 || image->GetWidth() < 1 ||
        image->GetHeight() < 1) {
        fault = "a format that is not kept, or no pixels";
        return std::nullopt;
    }
    Decoded decoded{{}, WrapOf(*image, HioAddressDimensionU), WrapOf(*image, HioAddressDimensionV)};
    decoded.tile.channels = channels;
    decoded.tile.format = *texels;
    const std::size_t bytes = static_cast<std::size_t>(image->GetWidth()) *
                              static_cast<std::size_t>(image->GetHeight()) *
                              static_cast<std::size_t>(channels) * irt::bytes_of(*texels);
    const std::shared_ptr<std::byte[]> data(new std::byte[bytes]);
    HioImage::StorageSpec storage;
    storage.width = image->GetWidth();
    storage.height = image->GetHeight();
    storage.depth = 1;
    storage.format = format;
    storage.data = data.get();
    if (!image->Read(storage)) {
        fault = "damaged";
        return std::nullopt;
    }
    MendFloats(*texels, data.get(), bytes);
    decoded.tile.levels.push_back(
        {storage.width, storage.height,
         std::shared_ptr<const std::byte>(data, static_cast<const std::byte*>(data.get()))});
    return decoded;
}

}  // namespace

HdIrtTexture HdIrtTextures::Find(const SdfAssetPath& asset, const std::string& space,
                                 const std::string& wrap_s, const std::string& wrap_t,
                                 const SdfPath& node) {
    const std::string file =
        asset.GetResolvedPath().empty() ? asset.GetAssetPath() : asset.GetResolvedPath();
    const auto wrapped = [&](std::shared_ptr<const irt::Texture> texture, const Loaded& loaded) {
        return HdIrtTexture{std::move(texture), Named(wrap_s, loaded.wrap_s),
                            Named(wrap_t, loaded.wrap_t)};
    };
    const std::lock_guard lock(_mutex);
    const auto known = _loaded.find({file, space});
    if (known != _loaded.end())
        if (auto texture = known->second.texture.lock()) return wrapped(texture, known->second);

    const std::size_t pattern = file.find(udimPattern);
    const bool udim = pattern != std::string::npos;
    std::vector<irt::Tile> tiles;
    Loaded loaded{{}, irt::Wrap::Black, irt::Wrap::Black};
    std::string fault = "no tile from 1001 to 1100 is there";
    for (int number = firstTile; number <= (udim ? lastTile : firstTile); ++number) {
        std::string name = file;
        if (udim) {
            name.replace(pattern, udimPattern.size(), std::to_string(number));
            if (ArGetResolver().Resolve(name).IsEmpty()) continue;
        }
        std::optional<Decoded> decoded = Decode(name, fault);
        if (!decoded) {
            tiles.clear();
            break;
        }
        if (udim) {
            decoded->tile.u = (number - firstTile) % 10;
            decoded->tile.v = (number - firstTile) / 10;
        }
        if (tiles.empty()) loaded = {{}, decoded->wrap_s, decoded->wrap_t};
        tiles.push_back(std::move(decoded->tile));
    }
    if (tiles.empty()) {
        TF_WARN("<%s>: the texture %s is not used, its fallback is rendered: %s", node.GetText(),
                file.c_str(), fault.c_str());
        return {};
    }
    const irt::Tile& first = tiles.front();
    const bool automatic = first.format == irt::TexelFormat::U8 && first.channels >= 3;
    const bool srgb = space == "sRGB" || (space != "raw" && automatic);
    if (space != "sRGB" && space != "raw" && space != "auto")
        TF_WARN("<%s>: the colour space %s is not known; it is taken for auto", node.GetText(),
                space.c_str());
    try {
        const auto texture = std::make_shared<const irt::Texture>(
            std::move(tiles), srgb ? irt::Transfer::Srgb : irt::Transfer::Linear,
            std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}, udim);
        loaded.texture = texture;
        _loaded[{file, space}] = loaded;
        return wrapped(texture, loaded);
    } catch (const std::invalid_argument& error) {
        TF_WARN("<%s>: the texture %s is not used, its fallback is rendered: %s", node.GetText(),
                file.c_str(), error.what());
        return {};
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
