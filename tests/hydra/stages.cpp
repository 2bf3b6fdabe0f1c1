// SPDX-License-Identifier: Apache-2.0
#include "stages.h"

#include <cmath>
#include <limits>

#include "pxr/base/gf/quath.h"
#include "pxr/usd/sdf/layer.h"
#include "pxr/usd/usdGeom/imageable.h"
#include "pxr/usd/usdGeom/mesh.h"
#include "pxr/usd/usdGeom/pointInstancer.h"
#include "pxr/usd/usdGeom/points.h"
#include "pxr/usd/usdGeom/primvarsAPI.h"
#include "pxr/usd/usdGeom/sphere.h"
#include "pxr/usd/usdGeom/xformable.h"
#include "pxr/usd/usdLux/distantLight.h"
#include "pxr/usd/usdLux/sphereLight.h"
#include "pxr/usd/usdShade/materialBindingAPI.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

UsdPrim At(const UsdStageRefPtr& stage, const char* path) {
    return stage->GetPrimAtPath(SdfPath(path));
}

double Uniform(std::mt19937& chance, double low, double high) {
    return low + (high - low) * (static_cast<double>(chance()) / std::mt19937::max());
}

GfVec3f Color(std::mt19937& chance) {
    return {static_cast<float>(Uniform(chance, 0, 1)), static_cast<float>(Uniform(chance, 0, 1)),
            static_cast<float>(Uniform(chance, 0, 1))};
}

template <class T>
void Set(const UsdStageRefPtr& stage, const char* path, const char* name, const T& value) {
    if (const UsdPrim prim = At(stage, path)) prim.GetAttribute(TfToken(name)).Set(value);
}

void Move(const UsdStageRefPtr& stage, const char* path, std::mt19937& chance) {
    Set(stage, path, "xformOp:translate",
        GfVec3d(Uniform(chance, -4, 4), Uniform(chance, 0, 2), Uniform(chance, -3, 4)));
}

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

UsdStageRefPtr MakeStage() {
    const SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    layer->Import(IRT_HYDRA_SHOT);
    return UsdStage::Open(layer);
}

UsdStageRefPtr CopyOf(const UsdStageRefPtr& stage) {
    const SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    layer->TransferContent(stage->GetRootLayer());
    return UsdStage::Open(layer);
}

const std::vector<Edit>& Edits() {
    using Stage = const UsdStageRefPtr&;
    using Chance = std::mt19937;
    static const std::vector<Edit> edits{
        {"move a mesh", [](Stage s, Chance& c) { Move(s, "/World/box", c); }},
        {"move a solid", [](Stage s, Chance& c) { Move(s, "/World/cone", c); }},
        {"move what is see-through", [](Stage s, Chance& c) { Move(s, "/World/cube", c); }},
        {"move an instance", [](Stage s, Chance& c) { Move(s, "/World/first", c); }},
        {"resize",
         [](Stage s, Chance& c) { Set(s, "/World/ball", "radius", Uniform(c, 0.5, 1.6)); }},
        {"colour",
         [](Stage s, Chance& c) { Set(s, "/World/looks/red/s", "inputs:diffuseColor", Color(c)); }},
        {"roughness",
         [](Stage s, Chance& c) {
             Set(s, "/World/looks/mirror/s", "inputs:roughness",
                 static_cast<float>(Uniform(c, 0, 0.3)));
         }},
        {"opacity",
         [](Stage s, Chance& c) {
             Set(s, "/World/looks/glass/s", "inputs:opacity", static_cast<float>(Uniform(c, 0, 1)));
         }},
        {"energy",
         [](Stage s, Chance& c) {
             Set(s, "/World/lamp", "inputs:intensity", static_cast<float>(Uniform(c, 0, 60)));
         }},
        {"light moves", [](Stage s, Chance& c) { Move(s, "/World/lamp", c); }},
        {"sun turns",
         [](Stage s, Chance& c) {
             Set(s, "/World/sun", "xformOp:rotateXYZ",
                 GfVec3f(-50, static_cast<float>(Uniform(c, 0, 90)), 0));
         }},
        {"visibility",
         [](Stage s, Chance& c) {
             const char* paths[] = {"/World/box",   "/World/ball",   "/World/lamp",
                                    "/World/trees", "/World/points", "/World/second"};
             const UsdGeomImageable prim(At(s, paths[c() % 6]));
             if (c() % 2)
                 prim.MakeInvisible();
             else
                 prim.MakeVisible();
         }},
        {"points",
         [](Stage s, Chance& c) {
             VtVec3fArray points{{-2, 2.5f, 0}, {-1, 3, 0}, {0, 2.6f, 0.5f}};
             points[c() % 3] += GfVec3f(0.1f, 0.2f, 0);
             Set(s, "/World/points", "points", points);
         }},
        {"mesh bends",
         [](Stage s, Chance& c) {
             VtVec3fArray points;
             const UsdAttribute attribute = At(s, "/World/box").GetAttribute(TfToken("points"));
             attribute.Get(&points);
             points[c() % points.size()] += GfVec3f(static_cast<float>(Uniform(c, -0.2, 0.2)));
             attribute.Set(points);
         }},
        {"display colour",
         [](Stage s, Chance& c) {
             Set(s, "/World/box", "primvars:displayColor", VtVec3fArray{Color(c)});
         }},
        {"paint",
         [](Stage s, Chance& c) {
             Set(s, "/World/ground", "primvars:paint",
                 VtVec3fArray{Color(c), Color(c), Color(c), Color(c)});
         }},
        {"entries",
         [](Stage s, Chance& c) {
             VtVec3fArray positions{{-5, 0, -2}, {-3.5f, 0, -3}, {5, 0, -3}, {6, 0, -1}};
             positions[c() % 4] += GfVec3f(0, static_cast<float>(Uniform(c, 0, 1)), 0);
             Set(s, "/World/trees", "positions", positions);
         }},
        {"prototypes",
         [](Stage s, Chance& c) {
             VtIntArray kinds{0, 1, 0, 1};
             kinds[c() % 4] = static_cast<int>(c() % 2);
             Set(s, "/World/trees", "protoIndices", kinds);
         }},
        {"binding",
         [](Stage s, Chance& c) {
             const char* looks[] = {"red", "mirror", "glass", "painted"};
             const SdfPath look = SdfPath("/World/looks").AppendChild(TfToken(looks[c() % 4]));
             const char* paths[] = {"/World/ball", "/World/cone", "/World/ground"};
             UsdShadeMaterialBindingAPI(At(s, paths[c() % 3]))
                 .Bind(UsdShadeMaterial(s->GetPrimAtPath(look)));
         }},
        {"prim comes or goes",
         [](Stage s, Chance& c) {
             const SdfPath path("/World/extra");
             if (s->GetPrimAtPath(path)) {
                 s->RemovePrim(path);
             } else {
                 const UsdGeomSphere sphere = UsdGeomSphere::Define(s, path);
                 sphere.AddTranslateOp().Set(GfVec3d(Uniform(c, -3, 3), 1, Uniform(c, 0, 4)));
                 sphere.GetRadiusAttr().Set(0.5);
             }
         }},
        {"light comes or goes",
         [](Stage s, Chance&) {
             const SdfPath path("/World/second_sun");
             if (s->GetPrimAtPath(path))
                 s->RemovePrim(path);
             else
                 UsdLuxDistantLight::Define(s, path).GetIntensityAttr().Set(1.0f);
         }},
    };
    return edits;
}

const std::vector<Edit>& InvalidEdits() {
    using Stage = const UsdStageRefPtr&;
    using Chance = std::mt19937;
    static const std::vector<Edit> edits{
        {"points that are no numbers",
         [](Stage s, Chance&) {
             Set(s, "/World/ground", "points", VtVec3fArray(4, GfVec3f(nan)));
         }},
        {"indices of no points",
         [](Stage s, Chance& c) {
             Set(s, "/World/ground", "faceVertexIndices",
                 VtIntArray{0, 1, static_cast<int>(c() % 9) - 3, 3});
         }},
        {"counts that do not add up",
         [](Stage s, Chance& c) {
             Set(s, "/World/box", "faceVertexCounts",
                 VtIntArray{4, static_cast<int>(c() % 9) - 3, 4});
         }},
        {"no points", [](Stage s, Chance&) { Set(s, "/World/box", "points", VtVec3fArray()); }},
        {"huge points",
         [](Stage s, Chance&) { Set(s, "/World/box", "points", VtVec3fArray(8, GfVec3f(3e38f))); }},
        {"a radius below 0", [](Stage s, Chance&) { Set(s, "/World/ball", "radius", -1.0); }},
        {"a flat scale",
         [](Stage s, Chance&) { Set(s, "/World/trees", "scales", VtVec3fArray(4, GfVec3f(0))); }},
        {"prototypes that are not there",
         [](Stage s, Chance& c) {
             Set(s, "/World/trees", "protoIndices", VtIntArray{0, static_cast<int>(c()), -5, 1});
         }},
        {"fewer rotations than instances",
         [](Stage s, Chance&) { Set(s, "/World/trees", "orientations", VtQuathArray(1)); }},
        {"an infinite light",
         [](Stage s, Chance&) {
             Set(s, "/World/lamp", "inputs:intensity", std::numeric_limits<float>::infinity());
         }},
        {"widths that are no numbers",
         [](Stage s, Chance&) {
             Set(s, "/World/points", "widths", VtFloatArray{nan, 1, 1});
         }},
        {"a curve of one vertex",
         [](Stage s, Chance&) {
             Set(s, "/World/curves", "curveVertexCounts", VtIntArray{1, 3});
         }},
        {"a place that is no number",
         [](Stage s, Chance&) {
             Set(s, "/World/cone", "xformOp:translate", GfVec3d(std::nan(""), 0, 0));
         }},
        {"paint for other points",
         [](Stage s, Chance& c) {
             Set(s, "/World/ground", "primvars:paint", VtVec3fArray(c() % 3, GfVec3f(1)));
         }},
        {"a material that reads itself",
         [](Stage s, Chance&) {
             if (const UsdPrim reader = At(s, "/World/looks/painted/r"))
                 reader.GetAttribute(TfToken("inputs:fallback"))
                     .SetConnections({SdfPath("/World/looks/painted/r.outputs:result")});
         }},
        {"a material goes", [](Stage s, Chance&) { s->RemovePrim(SdfPath("/World/looks/red")); }},
    };
    return edits;
}

PXR_NAMESPACE_CLOSE_SCOPE
