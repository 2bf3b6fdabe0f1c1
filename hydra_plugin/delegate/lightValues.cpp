// SPDX-License-Identifier: Apache-2.0
// The arithmetic is that of the command line's reader, operation by operation: both doors give the
// same bits.
#include "delegate/lightValues.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "pxr/imaging/hd/light.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/sdf/assetPath.h"
#include "pxr/usd/usdLux/blackbody.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr double pi = 3.141592653589793;

/// Seven digits: what a rotation leaves of the last bits is no change of size.
double Rounded(double scale) {
    char text[64];
    std::snprintf(text, sizeof(text), "%.7g", scale);
    return std::strtod(text, nullptr);
}

double DistantFactor(double angle, bool normalize) {
    angle = std::min(angle, 360.0);
    if (angle == 0) return 1;
    const double half = angle * (pi / 180) / 2;
    const double sine = std::sin(half);
    if (!normalize) return angle < 180 ? pi * std::pow(sine, 2) : pi;
    return angle <= 180 ? 1 : 1 / (2 - std::pow(sine, 2));
}

template <class T>
void Get(HdSceneDelegate& delegate, const SdfPath& id, const TfToken& name, T& out) {
    const VtValue value = delegate.GetLightParamValue(id, name);
    if (value.IsHolding<T>()) {
        out = value.UncheckedGet<T>();
        return;
    }
    const VtValue cast = VtValue::Cast<T>(value);
    if (!cast.IsEmpty()) out = cast.template UncheckedGet<T>();
}

bool Finite(const GfVec3f& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

}  // namespace

bool HdIrtLightValues::Read(HdSceneDelegate& delegate, const SdfPath& id) {
    const auto get = [&](const TfToken& name, auto& out) { Get(delegate, id, name, out); };
    get(HdLightTokens->intensity, intensity);
    get(HdLightTokens->exposure, exposure);
    get(HdLightTokens->color, color);
    get(HdLightTokens->enableColorTemperature, temperature_enabled);
    get(HdLightTokens->colorTemperature, temperature);
    get(HdLightTokens->normalize, normalize);
    get(HdLightTokens->diffuse, diffuse);
    get(HdLightTokens->specular, specular);
    get(HdLightTokens->angle, angle);
    get(HdLightTokens->radius, radius);
    get(HdLightTokens->width, width);
    get(HdLightTokens->height, height);
    get(HdLightTokens->length, length);
    get(HdLightTokens->shapingFocus, focus);
    get(HdLightTokens->shapingFocusTint, focus_tint);
    get(HdLightTokens->shapingConeAngle, cone_angle);
    get(HdLightTokens->shapingConeSoftness, cone_softness);
    get(HdLightTokens->shadowEnable, shadows);
    get(HdLightTokens->shadowColor, shadow_color);
    get(HdLightTokens->shadowDistance, shadow_distance);
    SdfAssetPath ies;
    get(HdLightTokens->shapingIesFile, ies);
    ies_file = ies.GetResolvedPath().empty() ? ies.GetAssetPath() : ies.GetResolvedPath();
    TfToken category;
    get(HdTokens->lightLink, category);
    link = category.GetString();
    for (const double number :
         {intensity, exposure, static_cast<double>(temperature), static_cast<double>(diffuse),
          static_cast<double>(specular), static_cast<double>(focus),
          static_cast<double>(cone_angle), static_cast<double>(cone_softness),
          static_cast<double>(shadow_distance)})
        if (!std::isfinite(number)) return false;
    for (const double size : {angle, radius, width, height, length})
        if (!std::isfinite(size) || size < 0) return false;
    return Finite(color) && Finite(focus_tint) && Finite(shadow_color);
}

GfVec3d HdIrtLightValues::Energy(double factor) const {
    const double scale = intensity * std::pow(2.0, exposure) * factor;
    GfVec3d tinted(color);
    if (temperature_enabled)
        tinted = GfCompMult(tinted, GfVec3d(UsdLuxBlackbodyTemperatureAsRgb(temperature)));
    return {tinted[0] * scale, tinted[1] * scale, tinted[2] * scale};
}

double HdIrtLightValues::Factor(const TfToken& type, const GfMatrix4d& world) const {
    if (type == HdPrimTypeTokens->distantLight) return DistantFactor(angle, normalize);
    const GfVec3d x = world.GetRow3(0), y = world.GetRow3(1), z = world.GetRow3(2);
    const double across = Rounded(GfCross(x, y).GetLength());
    if (type == HdPrimTypeTokens->rectLight) return normalize ? 1 : width * height * across;
    if (type == HdPrimTypeTokens->diskLight)
        return normalize ? 1 : pi * std::pow(radius, 2) * across;
    if (type == HdPrimTypeTokens->cylinderLight) {
        if (normalize) return 1 / pi;
        const double thick = std::pow(y.GetLength() * z.GetLength(), 0.5);
        return 2 * radius * length * Rounded(x.GetLength() * thick);
    }
    if (normalize) return 0.25;
    return pi * std::pow(radius * Rounded(std::cbrt(std::abs(world.GetDeterminant3()))), 2);
}

PXR_NAMESPACE_CLOSE_SCOPE
