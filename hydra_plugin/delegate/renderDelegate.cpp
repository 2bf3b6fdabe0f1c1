// SPDX-License-Identifier: Apache-2.0
#include "delegate/renderDelegate.h"

#include "delegate/aovs.h"
#include "delegate/curves.h"
#include "delegate/instancer.h"
#include "delegate/light.h"
#include "delegate/material.h"
#include "delegate/mesh.h"
#include "delegate/points.h"
#include "delegate/quadric.h"
#include "delegate/renderBuffer.h"
#include "delegate/renderPass.h"
#include "delegate/settings.h"
#include "pxr/imaging/hd/camera.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_DEFINE_PRIVATE_TOKENS(_tokens, (full));

HdIrtRenderDelegate::HdIrtRenderDelegate(const HdRenderSettingsMap& settings)
    : HdRenderDelegate(settings),
      _param(std::make_unique<HdIrtRenderParam>()),
      _registry(std::make_shared<HdResourceRegistry>()) {
    _PopulateDefaultSettings(HdIrtSettingDescriptors());
}

const TfTokenVector& HdIrtRenderDelegate::GetSupportedRprimTypes() const {
    static const TfTokenVector types{HdPrimTypeTokens->mesh,     HdPrimTypeTokens->sphere,
                                     HdPrimTypeTokens->cube,     HdPrimTypeTokens->cone,
                                     HdPrimTypeTokens->cylinder, HdPrimTypeTokens->capsule,
                                     HdPrimTypeTokens->points,   HdPrimTypeTokens->basisCurves};
    return types;
}

const TfTokenVector& HdIrtRenderDelegate::GetSupportedSprimTypes() const {
    static const TfTokenVector types = [] {
        TfTokenVector all{HdPrimTypeTokens->camera, HdPrimTypeTokens->material};
        all.insert(all.end(), HdIrtLightTypes().begin(), HdIrtLightTypes().end());
        return all;
    }();
    return types;
}

const TfTokenVector& HdIrtRenderDelegate::GetSupportedBprimTypes() const {
    static const TfTokenVector types{HdPrimTypeTokens->renderBuffer};
    return types;
}

HdRenderPassSharedPtr HdIrtRenderDelegate::CreateRenderPass(HdRenderIndex* index,
                                                            const HdRprimCollection& collection) {
    return std::make_shared<HdIrtRenderPass>(index, collection, *_param);
}

HdInstancer* HdIrtRenderDelegate::CreateInstancer(HdSceneDelegate* delegate, const SdfPath& id) {
    return new HdIrtInstancer(delegate, id);
}

void HdIrtRenderDelegate::DestroyInstancer(HdInstancer* instancer) { delete instancer; }

HdRprim* HdIrtRenderDelegate::CreateRprim(const TfToken& type, const SdfPath& id) {
    if (type == HdPrimTypeTokens->mesh) return new HdIrtMesh(id);
    if (type == HdPrimTypeTokens->points) return new HdIrtPoints(id);
    if (type == HdPrimTypeTokens->basisCurves) return new HdIrtCurves(id);
    if (HdIrtQuadric::Draws(type)) return new HdIrtQuadric(type, id);
    TF_WARN("<%s>: prims of type %s are not drawn", id.GetText(), type.GetText());
    return nullptr;
}

void HdIrtRenderDelegate::DestroyRprim(HdRprim* rprim) { delete rprim; }

HdSprim* HdIrtRenderDelegate::CreateSprim(const TfToken& type, const SdfPath& id) {
    if (type == HdPrimTypeTokens->camera) return new HdCamera(id);
    if (type == HdPrimTypeTokens->material) return new HdIrtMaterial(id);
    if (HdIrtLightPrim::Draws(type)) return new HdIrtLightPrim(type, id);
    return nullptr;
}

HdSprim* HdIrtRenderDelegate::CreateFallbackSprim(const TfToken& type) {
    return CreateSprim(type, SdfPath::EmptyPath());
}

void HdIrtRenderDelegate::DestroySprim(HdSprim* sprim) { delete sprim; }

HdBprim* HdIrtRenderDelegate::CreateBprim(const TfToken& type, const SdfPath& id) {
    return type == HdPrimTypeTokens->renderBuffer ? new HdIrtRenderBuffer(id) : nullptr;
}

HdBprim* HdIrtRenderDelegate::CreateFallbackBprim(const TfToken& type) {
    return CreateBprim(type, SdfPath::EmptyPath());
}

void HdIrtRenderDelegate::DestroyBprim(HdBprim* bprim) { delete bprim; }

HdAovDescriptor HdIrtRenderDelegate::GetDefaultAovDescriptor(const TfToken& name) const {
    const HdFormat format = HdIrtAovFormat(name);
    if (format == HdFormatInvalid) return {};
    VtValue clear{GfVec4f(0)};
    if (format == HdFormatInt32) clear = VtValue(-1);
    if (format == HdFormatFloat32) clear = VtValue(name == HdAovTokens->depth ? 1.0f : 0.0f);
    if (format == HdFormatFloat32Vec3) clear = VtValue(GfVec3f(0));
    return {format, false, clear};
}

HdRenderSettingDescriptorList HdIrtRenderDelegate::GetRenderSettingDescriptors() const {
    return HdIrtSettingDescriptors();
}

TfToken HdIrtRenderDelegate::GetMaterialBindingPurpose() const { return _tokens->full; }

bool HdIrtRenderDelegate::Pause() {
    _param->session.Pause();
    return true;
}

bool HdIrtRenderDelegate::Resume() {
    _param->session.Resume();
    return true;
}

bool HdIrtRenderDelegate::Stop(bool blocking) {
    _param->session.Stop(blocking);
    return true;
}

bool HdIrtRenderDelegate::Restart() {
    _param->session.Restart();
    return true;
}

PXR_NAMESPACE_CLOSE_SCOPE
