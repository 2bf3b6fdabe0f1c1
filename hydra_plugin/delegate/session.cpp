// SPDX-License-Identifier: Apache-2.0
#include "delegate/session.h"

#include <algorithm>
#include <exception>
#include <stdexcept>

#include "irt/math/stopwatch.h"
#include "irt/scene/equality.h"
#include "pxr/base/tf/diagnostic.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// A moving camera shows a picture of one pixel in 8 x 8 first, if that spares much.
constexpr int coarseness = 8;
constexpr int leastPixels = 256 * 256;

bool SameSettings(const irt::ViewSettings& a, const irt::ViewSettings& b) {
    return a.width == b.width && a.height == b.height && a.x == b.x && a.y == b.y &&
           a.frame_width == b.frame_width && a.frame_height == b.frame_height &&
           a.samples == b.samples && a.shade.max_depth == b.shade.max_depth &&
           a.shade.throughput_cutoff == b.shade.throughput_cutoff &&
           a.shade.mirror_roughness == b.shade.mirror_roughness && a.aovs == b.aovs;
}

bool SameSight(const HdIrtSight& a, const HdIrtSight& b) {
    return irt::same(a.camera, b.camera) && a.frame_width == b.frame_width &&
           a.frame_height == b.frame_height && a.x == b.x && a.y == b.y && a.width == b.width &&
           a.height == b.height;
}

bool SameRequest(const HdIrtRequest& a, const HdIrtRequest& b) {
    return SameSight(a.sight, b.sight) && a.sight.exposure == b.sight.exposure &&
           a.film_view.view == b.film_view.view &&
           a.film_view.projection == b.film_view.projection && a.bindings == b.bindings;
}

bool SameRenderer(const HdIrtSettings& a, const HdIrtSettings& b) {
    return a.threads == b.threads && a.history == b.history && a.render_origin == b.render_origin;
}

/// The records of a change set, each in one of its own, in an order in which they can be applied.
std::vector<irt::ChangeSet> Pieces(const irt::ChangeSet& changes) {
    std::vector<irt::ChangeSet> pieces;
    const auto add = [&](auto member, auto&& wanted) {
        for (const auto& [name, record] : changes.*member) {
            if (record.has_value() != wanted) continue;
            irt::ChangeSet piece;
            (piece.*member)[name] = record;
            pieces.push_back(std::move(piece));
        }
    };
    add(&irt::ChangeSet::materials, true);
    add(&irt::ChangeSet::lights, true);
    add(&irt::ChangeSet::objects, true);
    add(&irt::ChangeSet::objects, false);
    add(&irt::ChangeSet::lights, false);
    add(&irt::ChangeSet::materials, false);
    return pieces;
}

irt::ChangeSet Joined(std::vector<irt::ChangeSet> pieces) {
    irt::ChangeSet all;
    for (irt::ChangeSet& piece : pieces) {
        all.objects.merge(piece.objects);
        all.materials.merge(piece.materials);
        all.lights.merge(piece.lights);
    }
    return all;
}

/// What takes the place of a record that was refused: nothing, or a plain material.
irt::ChangeSet Instead(const irt::ChangeSet& piece) {
    irt::ChangeSet out;
    for (const auto& [name, record] : piece.objects) out.objects[name] = std::nullopt;
    for (const auto& [name, record] : piece.lights) out.lights[name] = std::nullopt;
    for (const auto& [name, record] : piece.materials) out.materials[name] = irt::Material{};
    return out;
}

}  // namespace

HdIrtSession::HdIrtSession(HdIrtScene& scene) : _scene(scene) {
    _thread.SetRenderCallback([this] { _Render(); });
    _thread.StartThread();
}

HdIrtSession::~HdIrtSession() {
    _control.stop = true;
    _stopped = true;
    _thread.StopThread();
}

void HdIrtSession::SetSettings(const HdIrtSettings& settings) {
    const std::lock_guard lock(_mutex);
    _settings = settings;
    for (auto& [id, pass] : _passes) ++pass.asked;
    _control.stop = true;
}

void HdIrtSession::Ask(const void* id, std::optional<HdIrtRequest> request) {
    bool wake = false;
    {
        const std::lock_guard lock(_mutex);
        Pass& pass = _passes[id];
        const bool same = request.has_value() == pass.request.has_value() &&
                          (!request || SameRequest(*request, *pass.request));
        if (!same) {
            // A picture that nobody waits for any longer is given up.
            if (pass.request && (!request || !SameSight(request->sight, pass.request->sight)))
                _control.stop = true;
            pass.request = std::move(request);
            ++pass.asked;
        }
        wake = pass.request && (pass.shown != pass.asked || pass.shown_scene != _scene.Serial());
        if (wake && pass.request)
            for (const HdIrtBinding& binding : pass.request->bindings)
                binding.pixels->converged = false;
    }
    if (wake && !_paused && !_stopped) _thread.StartRender();
}

void HdIrtSession::Forget(const void* id) {
    const std::lock_guard lock(_mutex);
    _passes.erase(id);
    _control.stop = true;
}

bool HdIrtSession::IsConverged(const void* id) const {
    if (_stopped) return true;
    const std::lock_guard lock(_mutex);
    const auto found = _passes.find(id);
    if (found == _passes.end() || !found->second.request) return true;
    const Pass& pass = found->second;
    return pass.shown == pass.asked && pass.shown_scene == _scene.Serial();
}

void HdIrtSession::Pause() {
    _paused = true;
    const std::lock_guard lock(_mutex);
    _control.stop = true;
}

void HdIrtSession::Resume() {
    _paused = false;
    if (!_stopped) _thread.StartRender();
}

void HdIrtSession::Stop(bool blocking) {
    _stopped = true;
    {
        const std::lock_guard lock(_mutex);
        _control.stop = true;
    }
    if (blocking) _thread.StopRender();
}

void HdIrtSession::Restart() {
    _stopped = false;
    if (!_paused) _thread.StartRender();
}

VtDictionary HdIrtSession::Stats() const {
    const std::lock_guard lock(_mutex);
    return _stats;
}

HdIrtSession::Work HdIrtSession::_NextWork() {
    const std::lock_guard lock(_mutex);
    _control.stop = _stopped || _paused;
    Work work;
    work.settings = _settings;
    for (const auto& [id, pass] : _passes)
        if (pass.request) work.passes[id] = pass;
    return work;
}

bool HdIrtSession::_Superseded(const Work& work) const {
    const std::lock_guard lock(_mutex);
    for (const auto& [id, pass] : work.passes) {
        const auto now = _passes.find(id);
        if (now == _passes.end() || now->second.asked != pass.asked) return true;
    }
    return false;
}

void HdIrtSession::_Render() {
    try {
        while (!_paused && !_stopped && _Step(_NextWork())) {
        }
    } catch (const std::exception& error) {
        // The next request starts anew.
        TF_WARN("irt: rendering failed: %s", error.what());
        _renderer.reset();
        const std::lock_guard lock(_mutex);
        for (auto& [id, pass] : _passes) {
            pass.shown = pass.asked;
            pass.shown_scene = _scene.Serial();
        }
    }
}

irt::ViewSettings HdIrtSession::_ViewSettings(const HdIrtRequest& request, bool coarse) const {
    const HdIrtSight& sight = request.sight;
    const auto part = [&](int pixels) {
        return coarse ? (pixels + coarseness - 1) / coarseness : pixels;
    };
    irt::ViewSettings settings;
    settings.width = part(sight.width);
    settings.height = part(sight.height);
    settings.x = coarse ? sight.x / coarseness : sight.x;
    settings.y = coarse ? sight.y / coarseness : sight.y;
    settings.frame_width = part(sight.frame_width);
    settings.frame_height = part(sight.frame_height);
    settings.samples = coarse ? 1 : _used.samples;
    settings.shade.max_depth = _used.max_depth;
    settings.shade.throughput_cutoff = _used.throughput_cutoff;
    settings.shade.mirror_roughness = _used.mirror_roughness;
    settings.aovs = _aovs;
    return settings;
}

std::optional<std::size_t> HdIrtSession::_FindSlot(const void* pass, const irt::Camera& camera,
                                                   const irt::ViewSettings& settings) const {
    for (std::size_t s = 0; s < _slots.size(); ++s)
        if (_slots[s].pass == pass && !_slots[s].coarse && irt::same(_slots[s].camera, camera) &&
            SameSettings(_slots[s].settings, settings))
            return s;
    return std::nullopt;
}

void HdIrtSession::_RemoveSlot(std::size_t slot) {
    _renderer->remove_view(slot);
    _slots.erase(_slots.begin() + static_cast<std::ptrdiff_t>(slot));
}

/// Those of passes that are gone, or of other settings.
void HdIrtSession::_DropSlots(const Work& work) {
    for (std::size_t s = _slots.size(); s-- > 0;) {
        const Slot& slot = _slots[s];
        const auto found = work.passes.find(slot.pass);
        const bool fits =
            found != work.passes.end() &&
            SameSettings(slot.settings, _ViewSettings(*found->second.request, slot.coarse));
        if (!fits) _RemoveSlot(s);
    }
}

void HdIrtSession::_PrepareRenderer(const Work& work) {
    if (_renderer && !SameRenderer(_used, work.settings)) {
        _renderer.reset();
        _slots.clear();
    }
    _used = work.settings;
    for (const auto& [id, pass] : work.passes)
        for (const HdIrtBinding& binding : pass.request->bindings)
            for (const irt::film::Aov aov : HdIrtFilmAovs(binding.name))
                if (std::find(_aovs.begin(), _aovs.end(), aov) == _aovs.end()) _aovs.push_back(aov);
    if (_renderer) {
        _DropSlots(work);
        return;
    }
    _slots.clear();
    _overBudget = false;
    const auto& [id, pass] = *work.passes.begin();
    const HdIrtSight& sight = pass.request->sight;
    irt::RendererOptions options;
    options.threads = _used.threads;
    options.history = _used.history;
    const irt::M44d& m = sight.camera.world_from_camera;
    options.render_origin = _used.render_origin.value_or(irt::V3d(m[3][0], m[3][1], m[3][2]));
    const irt::ViewSettings settings = _ViewSettings(*pass.request, false);
    _renderer = std::make_unique<irt::Renderer>(sight.camera, settings, options);
    _slots.push_back({id, sight.camera, settings, false, ++_clock, 0});
    _taken = 0;
}

/// The view that shows the request: one that does already, or one made so.
std::size_t HdIrtSession::_SlotFor(const void* id, const HdIrtRequest& request, bool coarse) {
    const irt::ViewSettings settings = _ViewSettings(request, coarse);
    const irt::Camera& camera = request.sight.camera;
    if (coarse) {
        for (std::size_t s = 0; s < _slots.size(); ++s)
            if (_slots[s].pass == id && _slots[s].coarse) {
                _slots[s].camera = camera;
                return s;
            }
    } else {
        if (const auto found = _FindSlot(id, camera, settings)) return *found;
        std::vector<std::size_t> others;
        for (std::size_t s = 0; s < _slots.size(); ++s)
            if (_slots[s].pass == id && !_slots[s].coarse) others.push_back(s);
        std::stable_sort(others.begin(), others.end(), [this](std::size_t a, std::size_t b) {
            return _slots[a].used < _slots[b].used;
        });
        const auto unfinished = std::find_if(others.begin(), others.end(), [this](std::size_t s) {
            return !_renderer->is_current(s);
        });
        std::optional<std::size_t> reused;
        if (unfinished != others.end())
            reused = *unfinished;
        else if (!others.empty() && others.size() > static_cast<std::size_t>(_used.recent_views))
            reused = others.front();
        if (reused) {
            _slots[*reused].camera = camera;
            return *reused;
        }
    }
    _renderer->add_view(camera, settings);
    _slots.push_back({id, camera, settings, coarse, 0, 0});
    return _slots.size() - 1;
}

bool HdIrtSession::_Step(const Work& work) {
    if (work.passes.empty()) return false;
    _PrepareRenderer(work);
    const std::uint64_t serial = _scene.Serial();
    const bool stale = _taken == 0 || serial != _taken;
    const bool waits = std::any_of(work.passes.begin(), work.passes.end(), [&](const auto& pass) {
        return pass.second.shown != pass.second.asked || pass.second.shown_scene != serial;
    });
    if (!stale && !waits) return false;

    irt::Stopwatch watch;
    irt::ChangeSet changes;
    if (stale) changes = _scene.Take(_taken == 0);
    _taken = std::max<std::uint64_t>(serial, 1);

    std::map<const void*, std::size_t> coarse;
    for (const auto& [id, pass] : work.passes) {
        const HdIrtSight& sight = pass.request->sight;
        const auto known = _FindSlot(id, sight.camera, _ViewSettings(*pass.request, false));
        const bool begun = known && (_renderer->is_current(*known) || _slots[*known].bytes != 0);
        if (!begun && sight.width * sight.height >= leastPixels)
            coarse[id] = _SlotFor(id, *pass.request, true);
    }
    if (!coarse.empty()) {
        std::vector<std::size_t> wanted;
        for (const auto& [id, slot] : coarse) wanted.push_back(slot);
        _Update(changes, wanted, true);
        changes = {};
        for (const auto& [id, slot] : coarse) _Show(slot, id, work.passes.at(id), false);
        if (_control.stop) return true;
    }

    std::vector<std::size_t> shown;
    std::vector<const void*> ids;
    for (const auto& [id, pass] : work.passes) {
        shown.push_back(_SlotFor(id, *pass.request, false));
        _slots[shown.back()].used = ++_clock;
        ids.push_back(id);
    }
    const std::vector<irt::UpdateReport> reports = _Update(changes, shown, false);
    for (std::size_t i = 0; i < shown.size(); ++i)
        if (_renderer->is_current(shown[i])) _Show(shown[i], ids[i], work.passes.at(ids[i]), true);
    if (!reports.empty()) {
        std::vector<irt::UpdateReport> told;
        for (const std::size_t slot : shown) told.push_back(reports[slot]);
        _Report(told, watch.lap());
    }
    _KeepWithinBudget(shown);
    if (_control.stop || _Superseded(work) || _scene.Serial() != _taken) return true;

    // Views that are not shown follow while nothing else is to be done.
    std::vector<std::size_t> recent;
    for (std::size_t s = 0; s < _slots.size(); ++s)
        if (!_slots[s].coarse && _renderer->catches_up(s)) recent.push_back(s);
    if (!recent.empty()) _Update({}, recent, false);
    for (std::size_t s = _slots.size(); s-- > 0;) {
        const bool used =
            std::any_of(shown.begin(), shown.end(), [&](std::size_t v) { return v == s; });
        if (!used && !_slots[s].coarse && !_renderer->is_current(s) && !_renderer->catches_up(s)) {
            _RemoveSlot(s);
            for (std::size_t& v : shown) v -= v > s ? 1 : 0;
        }
    }
    return true;
}

std::vector<irt::UpdateReport> HdIrtSession::_Update(const irt::ChangeSet& changes,
                                                     const std::vector<std::size_t>& wanted,
                                                     bool coarse) {
    std::vector<irt::ViewUpdate> views(_slots.size());
    for (std::size_t s = 0; s < _slots.size(); ++s) {
        views[s].wanted = std::find(wanted.begin(), wanted.end(), s) != wanted.end();
        views[s].keep_history = !coarse && !_overBudget;
        if (views[s].wanted) views[s].camera = _slots[s].camera;
    }
    std::vector<irt::UpdateReport> reports;
    try {
        reports = _renderer->update(changes, views, _control);
    } catch (const std::invalid_argument&) {
        if (changes.empty()) throw;
        _ApplyPieces(Pieces(changes));
        reports = _renderer->update({}, views, _control);
    }
    for (const std::size_t s : wanted) _slots[s].bytes = reports[s].history.all_bytes();
    return reports;
}

/// Halves what is refused until single records are: these are warned of and left out.
void HdIrtSession::_ApplyPieces(const std::vector<irt::ChangeSet>& pieces) {
    std::vector<irt::ViewUpdate> views(_slots.size());
    for (irt::ViewUpdate& view : views) view.wanted = false;
    irt::cells::Control control;
    try {
        _renderer->update(Joined(pieces), views, control);
    } catch (const std::invalid_argument& error) {
        if (pieces.size() == 1) {
            TF_WARN("irt: left out: %s", error.what());
            _renderer->update(Instead(pieces.front()), views, control);
            return;
        }
        const auto middle = pieces.begin() + static_cast<std::ptrdiff_t>(pieces.size() / 2);
        _ApplyPieces({pieces.begin(), middle});
        _ApplyPieces({middle, pieces.end()});
    }
}

void HdIrtSession::_KeepWithinBudget(const std::vector<std::size_t>& shown) {
    std::size_t total = 0;
    for (const Slot& slot : _slots) total += slot.bytes;
    const bool alone = total > _used.history_budget;
    while (total > _used.history_budget) {
        std::optional<std::size_t> oldest;
        for (std::size_t s = 0; s < _slots.size(); ++s) {
            const bool is_shown = std::find(shown.begin(), shown.end(), s) != shown.end();
            if (!is_shown && _slots[s].bytes != 0 &&
                (!oldest || _slots[s].used < _slots[*oldest].used))
                oldest = s;
        }
        if (!oldest) break;
        total -= _slots[*oldest].bytes;
        _slots[*oldest].bytes = 0;
        _renderer->release_history(*oldest);
    }
    if (!alone || total <= _used.history_budget) return;
    TF_WARN("irt: a history of %zu MiB is over the budget of %zu MiB: updates are full traces",
            total >> 20, _used.history_budget >> 20);
    _overBudget = true;
    for (const std::size_t s : shown) {
        _renderer->release_history(s);
        _slots[s].bytes = 0;
    }
}

void HdIrtSession::_Show(std::size_t slot, const void* id, const Pass& pass, bool final) {
    const irt::film::Film& film = _renderer->film(slot);
    for (const HdIrtBinding& binding : pass.request->bindings) {
        const bool picks = binding.name == "primId" || binding.name == "instanceId";
        if (picks && _picksOf != _taken) {
            _picks = _scene.Picks();
            _picksOf = _taken;
        }
        HdIrtWriteAov(film, pass.request->film_view, binding, _picks, _scratch);
    }
    if (!final) return;
    const std::lock_guard lock(_mutex);
    const auto found = _passes.find(id);
    if (found == _passes.end()) return;
    found->second.shown = pass.asked;
    found->second.shown_scene = _taken;
    const bool converged = found->second.asked == pass.asked && _scene.Serial() == _taken;
    for (const HdIrtBinding& binding : pass.request->bindings)
        binding.pixels->converged = converged;
}

void HdIrtSession::_Report(const std::vector<irt::UpdateReport>& reports, double seconds) {
    std::uint64_t all = 0, traced = 0, retraced = 0, changed = 0, bytes = 0;
    std::string restart;
    for (const irt::UpdateReport& report : reports) {
        all += report.all_rays;
        bytes += report.history.all_bytes();
        if (!report.restart.empty()) restart = report.restart;
        for (const irt::CellReport& cell : report.cells) {
            traced += cell.counts.rays.rays();
            retraced += cell.counts.retraced;
            changed += cell.counts.changed;
        }
    }
    const std::uint64_t fresh = std::min(all, std::max(traced, retraced));
    VtDictionary stats;
    stats["rays"] = VtValue(all);
    stats["raysRetraced"] = VtValue(fresh);
    stats["raysReused"] = VtValue(all - fresh);
    stats["raysChanged"] = VtValue(changed);
    stats["shareChanged"] =
        VtValue(all == 0 ? 0.0 : static_cast<double>(changed) / static_cast<double>(all));
    stats["updateSeconds"] = VtValue(seconds);
    stats["historyBytes"] = VtValue(bytes);
    stats["restart"] = VtValue(restart);
    const std::lock_guard lock(_mutex);
    _stats = std::move(stats);
}

PXR_NAMESPACE_CLOSE_SCOPE
