// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "delegate/renderBuffer.h"
#include "delegate/renderParam.h"
#include "pxr/imaging/hd/renderPass.h"

PXR_NAMESPACE_OPEN_SCOPE

/// One view of the scene. Execute asks for it and returns; the render thread fills the buffers.
class HdIrtRenderPass final : public HdRenderPass {
  public:
    HdIrtRenderPass(HdRenderIndex* index, const HdRprimCollection& collection,
                    HdIrtRenderParam& param);
    ~HdIrtRenderPass() override;

    bool IsConverged() const override;

  protected:
    void _Execute(const HdRenderPassStateSharedPtr& state, const TfTokenVector& tags) override;

  private:
    [[nodiscard]] std::vector<HdIrtBinding> _Bindings(const HdRenderPassState& state,
                                                      const HdIrtSight& sight);

    HdIrtRenderParam& _param;
    unsigned int _settingsVersion = 0;
    bool _settingsKnown = false;
    HdIrtRenderBuffer _color, _depth;  ///< of hosts that bind none
    std::set<std::string> _warned;     ///< AOVs
};

PXR_NAMESPACE_CLOSE_SCOPE
