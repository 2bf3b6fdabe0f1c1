// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "delegate/renderParam.h"
#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/imaging/hd/resourceRegistry.h"

PXR_NAMESPACE_OPEN_SCOPE

class HdIrtRenderDelegate final : public HdRenderDelegate {
  public:
    explicit HdIrtRenderDelegate(const HdRenderSettingsMap& settings);

    const TfTokenVector& GetSupportedRprimTypes() const override;
    const TfTokenVector& GetSupportedSprimTypes() const override;
    const TfTokenVector& GetSupportedBprimTypes() const override;
    HdRenderParam* GetRenderParam() const override { return _param.get(); }
    HdResourceRegistrySharedPtr GetResourceRegistry() const override { return _registry; }

    HdRenderPassSharedPtr CreateRenderPass(HdRenderIndex* index,
                                           const HdRprimCollection& collection) override;
    HdInstancer* CreateInstancer(HdSceneDelegate* delegate, const SdfPath& id) override;
    void DestroyInstancer(HdInstancer* instancer) override;
    HdRprim* CreateRprim(const TfToken& type, const SdfPath& id) override;
    void DestroyRprim(HdRprim* rprim) override;
    HdSprim* CreateSprim(const TfToken& type, const SdfPath& id) override;
    HdSprim* CreateFallbackSprim(const TfToken& type) override;
    void DestroySprim(HdSprim* sprim) override;
    HdBprim* CreateBprim(const TfToken& type, const SdfPath& id) override;
    HdBprim* CreateFallbackBprim(const TfToken& type) override;
    void DestroyBprim(HdBprim* bprim) override;
    void CommitResources(HdChangeTracker* /*tracker*/) override {}

    HdAovDescriptor GetDefaultAovDescriptor(const TfToken& name) const override;
    HdRenderSettingDescriptorList GetRenderSettingDescriptors() const override;
    VtDictionary GetRenderStats() const override { return _param->session.Stats(); }
    TfToken GetMaterialBindingPurpose() const override;

    bool IsPauseSupported() const override { return true; }
    bool IsPaused() const override { return _param->session.IsPaused(); }
    bool Pause() override;
    bool Resume() override;
    bool IsStopSupported() const override { return true; }
    bool IsStopped() const override { return _param->session.IsStopped(); }
    bool Stop(bool blocking) override;
    bool Restart() override;

  private:
    std::unique_ptr<HdIrtRenderParam> _param;
    HdResourceRegistrySharedPtr _registry;
};

PXR_NAMESPACE_CLOSE_SCOPE
