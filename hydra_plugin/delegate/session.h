// SPDX-License-Identifier: Apache-2.0
// The render thread: brings the films of all render passes up to the scene and their cameras, and
// the host's render buffers up to the films. No call of the host waits for it to trace.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "delegate/aovs.h"
#include "delegate/camera.h"
#include "delegate/scene.h"
#include "delegate/settings.h"
#include "irt/renderer.h"
#include "pxr/base/vt/dictionary.h"
#include "pxr/imaging/hd/renderThread.h"

PXR_NAMESPACE_OPEN_SCOPE

/// What a render pass wants to show.
struct HdIrtRequest {
    HdIrtSight sight;
    HdIrtFilmView film_view;
    std::vector<HdIrtBinding> bindings;
};

class HdIrtSession {
  public:
    explicit HdIrtSession(HdIrtScene& scene);
    ~HdIrtSession();

    void SetSettings(const HdIrtSettings& settings);
    /// What `pass` shows from now on; null: nothing. Starts rendering where there is something to
    /// do.
    void Ask(const void* pass, std::optional<HdIrtRequest> request);
    void Forget(const void* pass);
    /// Whether the buffers of `pass` show what was last asked for, of the scene as it is.
    [[nodiscard]] bool IsConverged(const void* pass) const;

    /// A paused session goes on where it was; one that was stopped renders no more until asked to.
    void Pause();
    void Resume();
    [[nodiscard]] bool IsPaused() const { return _paused; }
    void Stop(bool blocking);
    void Restart();
    [[nodiscard]] bool IsStopped() const { return _stopped && !_thread.IsRendering(); }

    /// Of the last update; see docs/hydra.md.
    [[nodiscard]] VtDictionary Stats() const;

  private:
    /// A render pass, as the host's thread knows it.
    struct Pass {
        std::optional<HdIrtRequest> request;
        std::uint64_t asked = 0;  ///< counts requests
        std::uint64_t shown = 0, shown_scene = 0;
    };
    /// A view of the renderer, by its number.
    struct Slot {
        const void* pass = nullptr;
        irt::Camera camera;
        irt::ViewSettings settings;
        bool coarse = false;
        std::uint64_t used = 0;  ///< when it was last shown
        std::size_t bytes = 0;   ///< of its history
    };
    struct Work {
        std::map<const void*, Pass> passes;
        HdIrtSettings settings;
    };

    void _Render();
    [[nodiscard]] Work _NextWork();
    /// One round; false where everything was up to date.
    bool _Step(const Work& work);
    void _PrepareRenderer(const Work& work);
    [[nodiscard]] irt::ViewSettings _ViewSettings(const HdIrtRequest& request, bool coarse) const;
    [[nodiscard]] std::optional<std::size_t> _FindSlot(const void* pass, const irt::Camera& camera,
                                                       const irt::ViewSettings& settings) const;
    std::size_t _SlotFor(const void* pass, const HdIrtRequest& request, bool coarse);
    void _RemoveSlot(std::size_t slot);
    void _DropSlots(const Work& work);
    void _KeepWithinBudget(const std::vector<std::size_t>& shown);
    std::vector<irt::UpdateReport> _Update(const irt::ChangeSet& changes,
                                           const std::vector<std::size_t>& wanted, bool coarse);
    void _ApplyPieces(const std::vector<irt::ChangeSet>& pieces);
    void _Show(std::size_t slot, const void* pass, const Pass& work, bool final);
    void _Report(const std::vector<irt::UpdateReport>& reports, double seconds);
    [[nodiscard]] bool _Superseded(const Work& work) const;

    HdIrtScene& _scene;
    mutable std::mutex _mutex;  ///< of what both threads see
    std::map<const void*, Pass> _passes;
    HdIrtSettings _settings;
    VtDictionary _stats;
    std::atomic<bool> _paused = false, _stopped = false;
    irt::cells::Control _control;

    // The render thread's own.
    std::unique_ptr<irt::Renderer> _renderer;
    HdIrtSettings _used;  ///< of the renderer
    std::vector<Slot> _slots;
    std::vector<irt::film::Aov> _aovs;  ///< of every view: all that were ever asked for
    std::uint64_t _taken = 0;           ///< what of the scene the renderer was told
    std::uint64_t _clock = 0;
    bool _overBudget = false;
    std::unordered_map<std::uint32_t, HdIrtPick> _picks;
    std::uint64_t _picksOf = ~std::uint64_t{0};
    std::vector<std::uint8_t> _scratch;

    mutable HdRenderThread _thread;
};

PXR_NAMESPACE_CLOSE_SCOPE
