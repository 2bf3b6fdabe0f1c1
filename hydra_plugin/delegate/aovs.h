// SPDX-License-Identifier: Apache-2.0
// Films as the AOVs that Hydra asks for.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "delegate/pixels.h"
#include "delegate/scene.h"
#include "irt/film/film.h"
#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/gf/vec4f.h"

PXR_NAMESPACE_OPEN_SCOPE

/// An AOV and where it goes.
struct HdIrtBinding {
    TfToken name;
    std::shared_ptr<HdIrtPixels> pixels;
    GfVec4f clear{0.0f};  ///< where nothing is seen

    bool operator==(const HdIrtBinding& other) const {
        return name == other.name && pixels == other.pixels && clear == other.clear;
    }
};

/// What else it takes to make them of a film.
struct HdIrtFilmView {
    GfMatrix4d view{1}, projection{1};
    float exposure = 1;  ///< what colours are multiplied by
};

/// What of HdAovTokens, primvars and the core's own names a film can give; false: nothing.
bool HdIrtKnowsAov(const TfToken& name);
/// The film's AOVs that `name` is made of.
std::vector<irt::film::Aov> HdIrtFilmAovs(const TfToken& name);
/// What a render buffer for `name` should be like.
HdFormat HdIrtAovFormat(const TfToken& name);

/// Writes `film` into `binding`'s pixels, scaled to their size by the nearest pixel. `scratch` is
/// memory to write into.
void HdIrtWriteAov(const irt::film::Film& film, const HdIrtFilmView& view,
                   const HdIrtBinding& binding,
                   const std::unordered_map<std::uint32_t, HdIrtPick>& picks,
                   std::vector<std::uint8_t>& scratch);

PXR_NAMESPACE_CLOSE_SCOPE
