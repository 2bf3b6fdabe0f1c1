// SPDX-License-Identifier: Apache-2.0
#include "host.h"

#include <chrono>
#include <stdexcept>
#include <thread>

#include "pxr/imaging/hd/camera.h"
#include "pxr/imaging/hd/rendererPluginRegistry.h"
#include "pxr/imaging/hd/task.h"

PXR_NAMESPACE_OPEN_SCOPE

class HostTask final : public HdTask {
  public:
    explicit HostTask(HostView& view) : HdTask(SdfPath("/task")), _view(view) {}
    void Sync(HdSceneDelegate*, HdTaskContext*, HdDirtyBits* bits) override {
        _view._pass->Sync();
        *bits = HdChangeTracker::Clean;
    }
    void Prepare(HdTaskContext*, HdRenderIndex* index) override {
        _view._state->Prepare(index->GetResourceRegistry());
    }
    void Execute(HdTaskContext*) override { _view._Execute(); }
    const TfTokenVector& GetRenderTags() const override {
        static const TfTokenVector tags{HdRenderTagTokens->geometry, HdRenderTagTokens->render};
        return tags;
    }

  private:
    HostView& _view;
};

HostView::HostView(HdRenderIndex& index, const SdfPath& camera, int width, int height,
                   const TfTokenVector& aovs)
    : _index(index), _camera(camera), _width(width), _height(height) {
    HdRenderDelegate& delegate = *index.GetRenderDelegate();
    const HdRprimCollection collection(HdTokens->geometry,
                                       HdReprSelector(HdReprTokens->smoothHull));
    _pass = delegate.CreateRenderPass(&index, collection);
    _state = delegate.CreateRenderPassState();
    for (const TfToken& name : aovs) {
        const HdAovDescriptor descriptor = delegate.GetDefaultAovDescriptor(name);
        HdRenderPassAovBinding binding;
        binding.aovName = name;
        binding.clearValue = descriptor.clearValue;
        binding.renderBuffer = static_cast<HdRenderBuffer*>(delegate.CreateBprim(
            HdPrimTypeTokens->renderBuffer, SdfPath("/aov_" + name.GetString())));
        binding.renderBuffer->Allocate({width, height, 1}, descriptor.format, false);
        _bindings.push_back(binding);
    }
    _task = std::make_shared<HostTask>(*this);
}

HostView::~HostView() {
    _pass.reset();
    for (const HdRenderPassAovBinding& binding : _bindings)
        _index.GetRenderDelegate()->DestroyBprim(binding.renderBuffer);
}

void HostView::_Execute() {
    const auto* camera =
        static_cast<const HdCamera*>(_index.GetSprim(HdPrimTypeTokens->camera, _camera));
    _state->SetCamera(camera);
    _state->SetFraming(CameraUtilFraming(GfRect2i(GfVec2i(0, 0), _width, _height)));
    _state->SetOverrideWindowPolicy(CameraUtilMatchHorizontally);
    _state->SetAovBindings(_bindings);
    _pass->Execute(_state, _task->GetRenderTags());
}

bool HostView::IsConverged() const { return _pass->IsConverged(); }

Pixels HostView::Read(const TfToken& aov) const {
    for (const HdRenderPassAovBinding& binding : _bindings) {
        if (binding.aovName != aov) continue;
        HdRenderBuffer& buffer = *binding.renderBuffer;
        const std::size_t count = static_cast<std::size_t>(_width) *
                                  static_cast<std::size_t>(_height) *
                                  HdGetComponentCount(buffer.GetFormat());
        const void* data = buffer.Map();
        Pixels pixels(count);
        for (std::size_t i = 0; i < count; ++i)
            pixels[i] = buffer.GetFormat() == HdFormatInt32
                            ? static_cast<float>(static_cast<const int*>(data)[i])
                            : static_cast<const float*>(data)[i];
        buffer.Unmap();
        return pixels;
    }
    throw std::out_of_range("no AOV " + aov.GetString());
}

Host::Host(const UsdStageRefPtr& stage, Path path, const HdRenderSettingsMap& settings)
    : _stage(stage),
      _delegate(HdRendererPluginRegistry::GetInstance().CreateRenderDelegate(
          TfToken("HdIrtRendererPlugin"), settings)) {
    if (!_delegate) throw std::runtime_error("the delegate's plugin is not found");
    _index.reset(HdRenderIndex::New(_delegate.Get(), {}));
    if (path == Path::SceneDelegate) {
        _sceneDelegate =
            std::make_unique<UsdImagingDelegate>(_index.get(), SdfPath::AbsoluteRootPath());
        _sceneDelegate->Populate(stage->GetPseudoRoot());
    } else {
        UsdImagingCreateSceneIndicesInfo info;
        info.stage = stage;
        info.addDrawModeSceneIndex = false;
        _sceneIndices = UsdImagingCreateSceneIndices(info);
        _index->InsertSceneIndex(_sceneIndices.finalSceneIndex, SdfPath::AbsoluteRootPath(), false);
    }
}

Host::~Host() {
    _views.clear();
    _sceneDelegate.reset();
    _index.reset();
}

HostView& Host::AddView(const std::string& camera, int width, int height,
                        const TfTokenVector& aovs) {
    _views.push_back(std::make_unique<HostView>(*_index, SdfPath(camera), width, height, aovs));
    return *_views.back();
}

void Host::SetTime(double time) {
    if (_sceneDelegate) _sceneDelegate->SetTime(UsdTimeCode(time));
    if (_sceneIndices.stageSceneIndex) _sceneIndices.stageSceneIndex->SetTime(UsdTimeCode(time));
}

void Host::Sync() {
    if (_sceneDelegate) _sceneDelegate->ApplyPendingUpdates();
    if (_sceneIndices.stageSceneIndex) _sceneIndices.stageSceneIndex->ApplyPendingUpdates();
    HdTaskSharedPtrVector tasks;
    for (const auto& view : _views) tasks.push_back(view->Task());
    _engine.Execute(_index.get(), &tasks);
}

void Host::Render() {
    const auto converged = [&] {
        for (const auto& view : _views)
            if (!view->IsConverged()) return false;
        return true;
    };
    do {
        Sync();
        for (int i = 0; i < 1000 && !converged(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (!converged());
}

PXR_NAMESPACE_CLOSE_SCOPE
