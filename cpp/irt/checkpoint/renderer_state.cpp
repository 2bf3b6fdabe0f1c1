// SPDX-License-Identifier: Apache-2.0
// Renderer::save and restore: what of a renderer outlives it.
#include <stdexcept>
#include <utility>

#include "irt/renderer.h"

namespace irt {

namespace {

std::string cell_name(const std::string& name, std::size_t k) {
    return name + "cell" + std::to_string(k / 10) + std::to_string(k % 10) + ".";
}

std::string view_name(std::size_t v) { return "view" + std::to_string(v) + "."; }

/// More than what alignment takes of a cell's arrays.
constexpr std::size_t room_to_align = 32 * alignof(std::max_align_t);

}  // namespace

template <class Archive, class Self>
void View::archive(Archive& to, const std::string& name, Self& self) {
    auto& [camera, settings, render_origin, render_from_camera, camera_from_render, eye, cone,
           sample_offsets, film, back, history, has_history] = self;
    film::Film::archive(to, name + "film.", film);
    to.value(name + "has_history", has_history);
    if (!has_history) return;
    if constexpr (Archive::reads) history = std::make_unique<History>();
    auto& [table, blocks, cells, lists] = *history;
    history::PathTable::archive(to, name + "table.", table);
    if constexpr (Archive::reads) {
        blocks[0].open(to.bytes(name + "cell") + cells.size() * room_to_align);
        for (std::size_t k = 0; k < cells.size(); ++k)
            history::archive(to, cell_name(name, k), cells[k], &blocks[0]);
        blocks[0].seal();
    } else {
        for (std::size_t k = 0; k < cells.size(); ++k)
            history::archive(to, cell_name(name, k), cells[k]);
    }
}

template <class Archive, class State>
void Renderer::archive(Archive& to, const std::string& name, State& state) {
    auto& [view, begun, film_is_current, behind, backoff, film_rays] = state;
    to.value(name + "begun", begun);
    to.value(name + "film_rays", film_rays);
    update::Backoff::archive(to, name + "backoff.", backoff);
    View::archive(to, name, view);
}

void Renderer::save(checkpoint::ArrayWriter& arrays) const {
    for (const auto& state : views_)
        if (!state->film_is_current) throw std::logic_error("a film is not that of its scene");
    if (!uncommitted_.empty()) throw std::logic_error("the trees are not those of the scene");
    SceneNames::archive(arrays, "names.", arrays.keep(scene_.names()));
    trace::TreesState::archive(arrays, "trees.", arrays.keep(intersector_.state()));
    arrays.value("views", static_cast<std::uint32_t>(views_.size()));
    arrays.value("foreseen", options_.foreseen != nullptr);
    for (std::size_t v = 0; v < views_.size(); ++v)
        archive(arrays, view_name(v), std::as_const(*views_[v]));
}

void Renderer::restore(const ChangeSet& scene, checkpoint::ArrayReader& arrays) {
    const FloatState ieee;
    if (committed_) throw std::logic_error("a renderer is restored before all else");
    std::uint32_t views = 0;
    arrays.value("views", views);
    if (views != views_.size()) throw std::runtime_error("views: there are others");
    bool foreseen = false;
    arrays.value("foreseen", foreseen);
    if (!foreseen) options_.foreseen = nullptr;
    SceneNames names;
    SceneNames::archive(arrays, "names.", names);
    scene_.adopt(names);
    const AppliedChanges applied = scene_.apply(scene);
    if (!(scene_.names() == names)) throw std::runtime_error("names: of another scene");
    trace::TreesState trees;
    trace::TreesState::archive(arrays, "trees.", trees);
    intersector_.commit(scene_, applied.geometry, trees);
    committed_ = true;
    for (std::size_t v = 0; v < views_.size(); ++v) {
        archive(arrays, view_name(v), *views_[v]);
        views_[v]->film_is_current = true;
    }
}

}  // namespace irt
