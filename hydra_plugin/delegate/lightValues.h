// SPDX-License-Identifier: Apache-2.0
// A light's parameters, and the energy that they give.
#pragma once

#include "irt/scene/records.h"
#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/imaging/hd/sceneDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

struct HdIrtLightValues {
    double intensity = 1, exposure = 0;
    GfVec3f color{1.0f}, focus_tint{0.0f}, shadow_color{0.0f};
    bool temperature_enabled = false, normalize = false, shadows = true;
    float temperature = 6500, diffuse = 1, specular = 1;
    double angle = 0.53, radius = 0.5, width = 1, height = 1, length = 1;
    float focus = 0, cone_angle = 180, cone_softness = 0, shadow_distance = -1;
    std::string ies_file;
    std::string link;  ///< the category of what it lights; empty: all

    /// False, and warned of, where a value is none that a light can have.
    bool Read(HdSceneDelegate& delegate, const SdfPath& id);
    /// Luminance times `factor`, per channel.
    [[nodiscard]] GfVec3d Energy(double factor) const;
    /// The greatest radiant intensity (of a distant light the irradiance) over luminance.
    [[nodiscard]] double Factor(const TfToken& type, const GfMatrix4d& world) const;
};

PXR_NAMESPACE_CLOSE_SCOPE
