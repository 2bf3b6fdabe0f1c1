// SPDX-License-Identifier: Apache-2.0
#include "delegate/aovs.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "pxr/base/gf/half.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using irt::film::Aov;
using irt::film::Film;

/// Up to four numbers of a pixel, in single precision, or one integer.
struct Value {
    GfVec4f numbers{0.0f};
    std::int32_t integer = 0;
};

bool IsInteger(const TfToken& name) {
    return name == HdAovTokens->primId || name == HdAovTokens->instanceId ||
           name == HdAovTokens->elementId;
}

template <class T>
void Store(std::uint8_t* at, std::size_t component, T value) {
    std::memcpy(at + component * sizeof(T), &value, sizeof(T));
}

void Write(std::uint8_t* at, HdFormat format, const Value& value, bool integer) {
    const std::size_t count = HdGetComponentCount(format);
    for (std::size_t c = 0; c < count; ++c) {
        const float number =
            integer ? static_cast<float>(value.integer) : value.numbers[static_cast<int>(c)];
        switch (HdGetComponentFormat(format)) {
            case HdFormatFloat32:
                Store(at, c, number);
                break;
            case HdFormatFloat16:
                Store(at, c, GfHalf(number).bits());
                break;
            case HdFormatInt32:
                Store(at, c,
                      integer ? value.integer : static_cast<std::int32_t>(std::lround(number)));
                break;
            case HdFormatUNorm8:
                Store(at, c,
                      static_cast<std::uint8_t>(
                          std::lround(std::clamp(number, 0.0f, 1.0f) * 255.0f)));
                break;
            case HdFormatSNorm8:
                Store(at, c,
                      static_cast<std::int8_t>(
                          std::lround(std::clamp(number, -1.0f, 1.0f) * 127.0f)));
                break;
            default:
                break;
        }
    }
}

/// One AOV of a film, pixel by pixel.
class Reader {
  public:
    Reader(const Film& film, const HdIrtFilmView& view, const HdIrtBinding& binding,
           const std::unordered_map<std::uint32_t, HdIrtPick>& picks)
        : _film(film), _view(view), _binding(binding), _picks(picks) {}

    [[nodiscard]] Value At(std::size_t i) const {
        const TfToken& name = _binding.name;
        Value value;
        value.numbers = _binding.clear;
        if (name == HdAovTokens->color) return _Color(i);
        if (IsInteger(name)) return _Integer(i);
        if (name == "irt.retraced") {
            value.numbers = GfVec4f(_film.retraced()[i], 0, 0, 0);
            return value;
        }
        if (_film.has(Aov::Depth) && _film.depth()[i] == 0) return value;
        if (name == HdAovTokens->depth) {
            const GfVec3d seen =
                _view.projection.Transform(GfVec3d(0, 0, -static_cast<double>(_film.depth()[i])));
            value.numbers = GfVec4f(static_cast<float>(seen[2] * 0.5 + 0.5), 0, 0, 0);
        } else if (name == HdAovTokens->cameraDepth) {
            value.numbers = GfVec4f(_film.depth()[i], 0, 0, 0);
        } else if (name == HdAovTokens->Neye) {
            const irt::V3f n = _film.vectors(Aov::Normal)[i];
            const GfVec3d eye = _view.view.TransformDir(GfVec3d(n.x, n.y, n.z)).GetNormalized();
            value.numbers = GfVec4f(static_cast<float>(eye[0]), static_cast<float>(eye[1]),
                                    static_cast<float>(eye[2]), 0);
        } else {
            const Aov aov = HdIrtFilmAovs(name).front();
            const irt::V3f v = _film.vectors(aov)[i];
            value.numbers = GfVec4f(v.x, v.y, v.z, 0);
        }
        return value;
    }

  private:
    [[nodiscard]] Value _Color(std::size_t i) const {
        const float* rgba = _film.beauty() + 4 * i;
        Value value;
        const float uncovered = 1 - rgba[3];
        for (int c = 0; c < 4; ++c) {
            float number = c < 3 && _view.exposure != 1 ? rgba[c] * _view.exposure : rgba[c];
            if (uncovered != 0 && _binding.clear[c] != 0) number += uncovered * _binding.clear[c];
            value.numbers[c] = number;
        }
        return value;
    }

    [[nodiscard]] Value _Integer(std::size_t i) const {
        Value value;
        value.integer = -1;
        const auto pick = _picks.find(_film.object_id()[i]);
        if (pick == _picks.end()) return value;
        if (_binding.name == HdAovTokens->primId) value.integer = pick->second.prim_id;
        if (_binding.name == HdAovTokens->instanceId) value.integer = pick->second.instance_id;
        return value;
    }

    const Film& _film;
    const HdIrtFilmView& _view;
    const HdIrtBinding& _binding;
    const std::unordered_map<std::uint32_t, HdIrtPick>& _picks;
};

}  // namespace

std::vector<Aov> HdIrtFilmAovs(const TfToken& name) {
    if (name == HdAovTokens->depth || name == HdAovTokens->cameraDepth) return {Aov::Depth};
    if (name == HdAovTokens->normal || name == HdAovTokens->Neye) return {Aov::Normal, Aov::Depth};
    if (IsInteger(name)) return {Aov::ObjectId};
    if (name == "position") return {Aov::Position, Aov::Depth};
    if (name == "albedo") return {Aov::Albedo, Aov::Depth};
    if (name == "irt.retraced") return {Aov::Retraced};
    return {};
}

bool HdIrtKnowsAov(const TfToken& name) {
    return name == HdAovTokens->color || !HdIrtFilmAovs(name).empty();
}

HdFormat HdIrtAovFormat(const TfToken& name) {
    if (name == HdAovTokens->color) return HdFormatFloat32Vec4;
    if (IsInteger(name)) return HdFormatInt32;
    if (name == HdAovTokens->depth || name == HdAovTokens->cameraDepth || name == "irt.retraced")
        return HdFormatFloat32;
    return HdIrtKnowsAov(name) ? HdFormatFloat32Vec3 : HdFormatInvalid;
}

void HdIrtWriteAov(const Film& film, const HdIrtFilmView& view, const HdIrtBinding& binding,
                   const std::unordered_map<std::uint32_t, HdIrtPick>& picks,
                   std::vector<std::uint8_t>& scratch) {
    HdIrtPixels& pixels = *binding.pixels;
    scratch.resize(pixels.Size());
    const std::size_t size = HdDataSizeOfFormat(pixels.format);
    const Reader reader(film, view, binding, picks);
    const bool integer = IsInteger(binding.name);
    const auto width = static_cast<std::size_t>(film.width());
    std::uint8_t* at = scratch.data();
    for (int row = 0; row < pixels.height; ++row) {
        // The film's row 0 is the topmost.
        const auto y = static_cast<std::size_t>(
            film.height() - 1 - row * static_cast<long>(film.height()) / pixels.height);
        for (int column = 0; column < pixels.width; ++column, at += size) {
            const auto x =
                static_cast<std::size_t>(column * static_cast<long>(film.width()) / pixels.width);
            Write(at, pixels.format, reader.At(y * width + x), integer);
        }
    }
    pixels.Replace(scratch);
}

PXR_NAMESPACE_CLOSE_SCOPE
