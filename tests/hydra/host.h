// SPDX-License-Identifier: Apache-2.0
// A headless host of the delegate: a stage, a render index and one task a view.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pxr/imaging/hd/engine.h"
#include "pxr/imaging/hd/pluginRenderDelegateUniqueHandle.h"
#include "pxr/imaging/hd/renderBuffer.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/renderPass.h"
#include "pxr/imaging/hd/renderPassState.h"
#include "pxr/imaging/hd/rprimCollection.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/usd/stage.h"
#include "pxr/usdImaging/usdImaging/delegate.h"
#include "pxr/usdImaging/usdImaging/sceneIndices.h"
#include "pxr/usdImaging/usdImaging/stageSceneIndex.h"

PXR_NAMESPACE_OPEN_SCOPE

/// How the stage reaches Hydra.
enum class Path { SceneIndex, SceneDelegate };

/// A film: rows from the lowest one, RGBA.
using Pixels = std::vector<float>;

/// One view: a render pass with buffers of its own.
class HostView {
  public:
    HostView(HdRenderIndex& index, const SdfPath& camera, int width, int height,
             const TfTokenVector& aovs);
    ~HostView();

    void SetCamera(const SdfPath& camera) { _camera = camera; }
    [[nodiscard]] const HdTaskSharedPtr& Task() const { return _task; }
    [[nodiscard]] bool IsConverged() const;
    /// Of float or int AOVs, whichever they are, as floats.
    [[nodiscard]] Pixels Read(const TfToken& aov) const;
    [[nodiscard]] HdRenderPass& Pass() const { return *_pass; }

  private:
    friend class HostTask;
    void _Execute();

    HdRenderIndex& _index;
    SdfPath _camera;
    int _width, _height;
    HdRenderPassSharedPtr _pass;
    HdRenderPassStateSharedPtr _state;
    HdRenderPassAovBindingVector _bindings;
    HdTaskSharedPtr _task;
};

class Host {
  public:
    Host(const UsdStageRefPtr& stage, Path path, const HdRenderSettingsMap& settings = {});
    ~Host();

    HostView& AddView(const std::string& camera, int width, int height,
                      const TfTokenVector& aovs = {HdAovTokens->color});
    void SetTime(double time);
    /// Hands the stage's edits on, and has every view executed once.
    void Sync();
    /// Syncs until every view is converged.
    void Render();
    [[nodiscard]] HdRenderDelegate& Delegate() const { return *_delegate; }
    [[nodiscard]] HdRenderIndex& Index() const { return *_index; }

  private:
    UsdStageRefPtr _stage;
    HdPluginRenderDelegateUniqueHandle _delegate;
    std::unique_ptr<HdRenderIndex> _index;
    std::unique_ptr<UsdImagingDelegate> _sceneDelegate;
    UsdImagingSceneIndices _sceneIndices;
    HdEngine _engine;
    std::vector<std::unique_ptr<HostView>> _views;
};

PXR_NAMESPACE_CLOSE_SCOPE
