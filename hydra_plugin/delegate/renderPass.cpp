// SPDX-License-Identifier: Apache-2.0
#include "delegate/renderPass.h"

#include "pxr/base/gf/vec3f.h"
#include "pxr/base/gf/vec3i.h"
#include "pxr/imaging/hd/camera.h"
#include "pxr/imaging/hd/renderIndex.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

GfVec4f Clear(const VtValue& value) {
    if (value.IsHolding<GfVec4f>()) return value.UncheckedGet<GfVec4f>();
    if (value.IsHolding<GfVec3f>()) {
        const auto& v = value.UncheckedGet<GfVec3f>();
        return {v[0], v[1], v[2], 1};
    }
    if (value.IsHolding<float>()) return GfVec4f(value.UncheckedGet<float>());
    return GfVec4f(0);
}

/// White and without shadow, along the view: a white Lambert surface that faces it returns 1.
irt::Light CameraLight(const irt::Camera& camera) {
    const irt::M44d& m = camera.world_from_camera;
    irt::Light light;
    light.kind = irt::LightKind::Distant;
    light.direction = irt::V3d(-m[2][0], -m[2][1], -m[2][2]).normalized();
    const auto pi = static_cast<float>(M_PI);
    light.energy = {pi, pi, pi};
    light.casts_shadows = false;
    return light;
}

}  // namespace

HdIrtRenderPass::HdIrtRenderPass(HdRenderIndex* index, const HdRprimCollection& collection,
                                 HdIrtRenderParam& param)
    : HdRenderPass(index, collection),
      _param(param),
      _color(SdfPath::EmptyPath()),
      _depth(SdfPath::EmptyPath()) {}

HdIrtRenderPass::~HdIrtRenderPass() { _param.session.Forget(this); }

bool HdIrtRenderPass::IsConverged() const { return _param.session.IsConverged(this); }

void HdIrtRenderPass::_Execute(const HdRenderPassStateSharedPtr& state, const TfTokenVector& tags) {
    const HdRenderDelegate& delegate = *GetRenderIndex()->GetRenderDelegate();
    const unsigned int version = delegate.GetRenderSettingsVersion();
    const HdIrtSettings settings = HdIrtReadSettings(delegate);
    if (!_settingsKnown || version != _settingsVersion) {
        _settingsKnown = true;
        _settingsVersion = version;
        _param.session.SetSettings(settings);
    }
    _param.scene.SetRenderTags(tags);
    const std::optional<HdIrtSight> sight = HdIrtSightOf(*state);
    if (!sight) {
        if (_warned.insert("").second)
            TF_WARN("irt: nothing to show: the image has no pixels, or <%s> is no camera",
                    state->GetCamera() ? state->GetCamera()->GetId().GetText() : "the camera");
        _param.session.Ask(this, std::nullopt);
        return;
    }
    _warned.erase("");
    _param.scene.SetCameraLight(settings.camera_light ? std::optional(CameraLight(sight->camera))
                                                      : std::nullopt);
    HdIrtRequest request;
    request.sight = *sight;
    request.film_view.view = state->GetWorldToViewMatrix();
    request.film_view.projection = state->GetProjectionMatrix();
    request.film_view.exposure = sight->exposure;
    request.bindings = _Bindings(*state, *sight);
    _param.session.Ask(this, std::move(request));
}

std::vector<HdIrtBinding> HdIrtRenderPass::_Bindings(const HdRenderPassState& state,
                                                     const HdIrtSight& sight) {
    std::vector<HdIrtBinding> bindings;
    for (const HdRenderPassAovBinding& binding : state.GetAovBindings()) {
        auto* buffer = dynamic_cast<HdIrtRenderBuffer*>(binding.renderBuffer);
        if (!buffer || buffer->GetFormat() == HdFormatInvalid) continue;
        if (!HdIrtKnowsAov(binding.aovName)) {
            if (_warned.insert(binding.aovName.GetString()).second)
                TF_WARN("irt: no AOV '%s'; its buffer <%s> is left as it is",
                        binding.aovName.GetText(), buffer->GetId().GetText());
            buffer->Pixels()->converged = true;
            continue;
        }
        if (buffer->GetWidth() == 0 || buffer->GetHeight() == 0) continue;
        bindings.push_back({binding.aovName, buffer->Pixels(), Clear(binding.clearValue)});
    }
    if (!state.GetAovBindings().empty()) return bindings;
    const GfVec3i size(sight.width, sight.height, 1);
    if (_color.GetWidth() != static_cast<unsigned>(size[0]) ||
        _color.GetHeight() != static_cast<unsigned>(size[1])) {
        _color.Allocate(size, HdFormatFloat32Vec4, false);
        _depth.Allocate(size, HdFormatFloat32, false);
    }
    bindings.push_back({HdAovTokens->color, _color.Pixels(), GfVec4f(0)});
    bindings.push_back({HdAovTokens->depth, _depth.Pixels(), GfVec4f(1)});
    return bindings;
}

PXR_NAMESPACE_CLOSE_SCOPE
