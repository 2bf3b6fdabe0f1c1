// SPDX-License-Identifier: Apache-2.0
#include "delegate/light.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "delegate/convert.h"
#include "delegate/lightValues.h"
#include "delegate/renderParam.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr double pi = 3.141592653589793;
constexpr int domeDirections = 32;

irt::V3f Single(const GfVec3d& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

/// Of unit length; empty for none.
std::optional<GfVec3d> Unit(const GfVec3d& v) {
    const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    if (largest == 0 || !std::isfinite(largest)) return std::nullopt;
    const double x = v[0] / largest, y = v[1] / largest, z = v[2] / largest;
    // Rounded once, as the other reader's length is.
    const auto square = [](double c) { return static_cast<long double>(c) * c; };
    const auto length = static_cast<double>(std::sqrt(square(x) + square(y) + square(z)));
    return GfVec3d(x / length, y / length, z / length);
}

irt::V3d Vector(const GfVec3d& v) { return {v[0], v[1], v[2]}; }

/// Profile, axis and side of a point light that stands for a light of an area.
void Shape(const TfToken& type, const GfMatrix4d& world, GfVec3d axis, irt::Light& light) {
    const GfVec3d x = world.GetRow3(0), y = world.GetRow3(1);
    if (type == HdPrimTypeTokens->rectLight || type == HdPrimTypeTokens->diskLight) {
        const GfVec3d normal = GfCross(x, y);
        axis = Unit(GfDot(normal, axis) > 0 ? normal : -normal).value_or(axis);
        light.profile = irt::Profile::Facing;
    }
    std::optional<GfVec3d> along;
    if (type == HdPrimTypeTokens->cylinderLight) {
        light.profile = irt::Profile::Round;
        along = Unit(x);
    }
    if (!along) along = Unit(x - GfDot(x, axis) * axis);
    if (!along) along = Unit(GfCross(axis, GfVec3d(0, 1, 0)));
    light.direction = Vector(axis);
    light.side = Vector(along.value_or(GfVec3d(1, 0, 0)));
}

/// Unit directions in which light travels, spread evenly over the sphere (Fibonacci's).
irt::V3d DomeDirection(int i) {
    const double golden = pi * (3 - std::sqrt(5.0));
    const double y = 1 - static_cast<double>(2 * i + 1) / domeDirections;
    const double r = std::sqrt(1 - y * y);
    return {r * std::cos(golden * i), y, r * std::sin(golden * i)};
}

}  // namespace

const TfTokenVector& HdIrtLightTypes() {
    static const TfTokenVector types{HdPrimTypeTokens->distantLight,  HdPrimTypeTokens->sphereLight,
                                     HdPrimTypeTokens->rectLight,     HdPrimTypeTokens->diskLight,
                                     HdPrimTypeTokens->cylinderLight, HdPrimTypeTokens->domeLight};
    return types;
}

bool HdIrtLightPrim::Draws(const TfToken& type) {
    const TfTokenVector& types = HdIrtLightTypes();
    return std::find(types.begin(), types.end(), type) != types.end();
}

void HdIrtLightPrim::Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits) {
    HdIrtScene& scene = static_cast<HdIrtRenderParam*>(param)->scene;
    const SdfPath& id = GetId();
    *dirtyBits = Clean;
    HdIrtLightValues values;
    const bool sound = values.Read(*delegate, id);
    const GfMatrix4d world = delegate->GetTransform(id);
    const bool finite = std::all_of(world.GetArray(), world.GetArray() + 16,
                                    [](double v) { return std::isfinite(v); });
    const bool dome = _type == HdPrimTypeTokens->domeLight;
    const bool distant = _type == HdPrimTypeTokens->distantLight;
    const GfVec3d energy = values.Energy(dome ? 1 : values.Factor(_type, world));
    const bool single = std::all_of(energy.data(), energy.data() + 3, [](double v) {
        return std::isfinite(v) && std::abs(v) <= 3.4e38;
    });
    if (!sound || !finite || !single) {
        TF_WARN("<%s>: its %s; it does not shine", id.GetText(),
                !sound    ? "parameters hold a NaN, an infinity or a size below 0"
                : !finite ? "transform holds a NaN or an infinity"
                          : "energy exceeds single precision");
        return scene.RemoveLight(id);
    }
    if (!delegate->GetVisible(id)) return scene.SetLight(id, {});

    HdIrtLight out;
    out.link = values.link;
    irt::Light light;
    light.casts_shadows = values.shadows;
    light.diffuse = values.diffuse;
    light.specular = values.specular;
    const std::string name = HdIrtName(*delegate, id);
    if (dome) {
        irt::Light sky;
        sky.kind = irt::LightKind::Environment;
        sky.energy = Single(energy);
        sky.casts_shadows = false;
        out.records[name] = sky;
        const double share = 4 * pi / domeDirections;
        light.energy = Single({energy[0] * share, energy[1] * share, energy[2] * share});
        for (int i = 0; i < domeDirections; ++i) {
            char number[16];
            std::snprintf(number, sizeof(number), "#%04d", i);
            light.direction = DomeDirection(i);
            out.records[name + number] = light;
        }
        return scene.SetLight(id, std::move(out));
    }
    light.energy = Single(energy);
    light.shadow_color = HdIrtVector(values.shadow_color);
    light.shadow_distance = values.shadow_distance;
    const std::optional<GfVec3d> axis = Unit(-world.GetRow3(2));
    if (distant) {
        if (!axis) {
            TF_WARN("<%s>: its transform leaves it no direction; it does not shine", id.GetText());
            return scene.RemoveLight(id);
        }
        light.direction = Vector(*axis);
    } else {
        light.kind = irt::LightKind::Point;
        light.position = Vector(world.ExtractTranslation());
        light.focus = values.focus;
        light.focus_tint = HdIrtVector(values.focus_tint);
        light.cone_softness = values.cone_softness;
        if (values.cone_angle < 180) light.cone_angle = std::max(values.cone_angle, 0.0f);
        const irt::Light plain;
        const bool turned = _type != HdPrimTypeTokens->sphereLight || light.focus != 0 ||
                            light.focus_tint != plain.focus_tint || light.cone_softness != 0 ||
                            light.cone_angle != 180 || light.shadow_color != plain.shadow_color ||
                            light.shadow_distance != plain.shadow_distance;
        if (turned && !axis) {
            TF_WARN("<%s>: its transform leaves it no direction; it does not shine", id.GetText());
            return scene.RemoveLight(id);
        }
        if (turned) Shape(_type, world, *axis, light);
        if (!values.ies_file.empty())
            TF_WARN("<%s>: IES files are not read; it shines without", id.GetText());
    }
    out.records[name] = light;
    scene.SetLight(id, std::move(out));
}

void HdIrtLightPrim::Finalize(HdRenderParam* param) {
    static_cast<HdIrtRenderParam*>(param)->scene.RemoveLight(GetId());
}

PXR_NAMESPACE_CLOSE_SCOPE
