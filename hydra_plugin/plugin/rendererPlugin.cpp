// SPDX-License-Identifier: Apache-2.0
#include "pxr/imaging/hd/rendererPlugin.h"
#include "delegate/renderDelegate.h"
#include "pxr/imaging/hd/rendererPluginRegistry.h"

PXR_NAMESPACE_OPEN_SCOPE

/// What hosts list as "irt".
class HdIrtRendererPlugin final : public HdRendererPlugin {
  public:
    HdRenderDelegate* CreateRenderDelegate() override { return new HdIrtRenderDelegate({}); }
    HdRenderDelegate* CreateRenderDelegate(const HdRenderSettingsMap& settings) override {
        return new HdIrtRenderDelegate(settings);
    }
    void DeleteRenderDelegate(HdRenderDelegate* delegate) override { delete delegate; }
    bool IsSupported(bool /*gpuEnabled*/) const override { return true; }
};

TF_REGISTRY_FUNCTION(TfType) { HdRendererPluginRegistry::Define<HdIrtRendererPlugin>(); }

PXR_NAMESPACE_CLOSE_SCOPE
