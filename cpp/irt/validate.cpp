// SPDX-License-Identifier: Apache-2.0
// A view against its own history: for tests.
#include <stdexcept>
#include <string>

#include "irt/history/invariants.h"
#include "irt/math/bits.h"
#include "irt/math/float_state.h"
#include "irt/renderer.h"
#include "irt/shade/whitted.h"

namespace irt {

namespace {

/// Throws where a pixel of one film is not that of the other.
template <class T>
void require_same(const T* kept, const T* recorded, std::size_t count, std::size_t per_pixel,
                  int width, const char* what) {
    for (std::size_t i = 0; i < count * per_pixel; ++i) {
        if (same_bits(kept[i], recorded[i])) continue;
        const std::size_t pixel = i / per_pixel, row = static_cast<std::size_t>(width);
        throw std::logic_error("pixel (" + std::to_string(pixel % row) + ", " +
                               std::to_string(pixel / row) + "): broken: its " + what +
                               " is what its samples recorded");
    }
}

void require_same(const film::Film& kept, const film::Film& recorded) {
    const int width = kept.width();
    const std::size_t pixels =
        static_cast<std::size_t>(width) * static_cast<std::size_t>(kept.height());
    using film::Aov;
    require_same(kept.beauty(), recorded.beauty(), pixels, 4, width, "beauty");
    if (kept.has(Aov::Depth))
        require_same(kept.depth(), recorded.depth(), pixels, 1, width, "depth");
    for (const Aov aov : {Aov::Normal, Aov::Position, Aov::Albedo})
        if (kept.has(aov))
            require_same(kept.vectors(aov), recorded.vectors(aov), pixels, 1, width,
                         film::aov_names[static_cast<std::size_t>(aov)].data());
    for (const Aov aov : {Aov::ObjectId, Aov::InstanceId, Aov::ElementId})
        if (kept.has(aov))
            require_same(kept.ids(aov), recorded.ids(aov), pixels, 1, width,
                         film::aov_names[static_cast<std::size_t>(aov)].data());
    for (const Aov aov : {Aov::CryptoObject, Aov::CryptoMaterial})
        if (kept.has(aov))
            require_same(kept.coverage(aov), recorded.coverage(aov), pixels, kept.ranks(), width,
                         film::aov_names[static_cast<std::size_t>(aov)].data());
    for (std::size_t p = 0; p < kept.primvar_count(); ++p)
        require_same(kept.primvar(p), recorded.primvar(p), pixels, 1, width, "primvar");
    for (std::size_t p = 0; p < kept.part_count(); ++p)
        require_same(kept.part(p), recorded.part(p), pixels, 1, width, "part of the beauty");
}

}  // namespace

void View::validate(const Scene& scene, const trace::Intersector& intersector) const {
    const shade::Shading shading(scene, settings_.shade, cone_);
    const update::Plan nothing;
    film::Film recorded(film_);
    const Parts parts = shade::resolved(settings_.parts, scene);
    const shade::Whitted<trace::Intersector> whitted(scene, intersector, settings_.shade, cone_);
    shade::Scratch scratch = whitted.make_scratch();
    for (int k = 0; k < cells::cell_count; ++k) {
        const std::string where = "cell " + std::to_string(k);
        const auto require = [&](bool holds, const char* invariant) {
            if (!holds) throw std::logic_error(where + ": broken: " + invariant);
        };
        history::RayTrees& trees = history_->cells[static_cast<std::size_t>(k)];
        check_invariants(trees, history_->table, shading, intersector, where);
        update::CellLists lists;
        const update::CellUpdate cell(shading, intersector, nothing, history_->table, trees, lists);
        history::SampleIndex sample = 0;
        scratch.counts = {};
        const auto [dx, dy] = settings_.first_pixel(k);
        for (int y = dy; y < settings_.height; y += cells::cell_stride)
            for (int x = dx; x < settings_.width; x += cells::cell_stride) {
                const history::SampleIndex first = sample;
                sample += static_cast<history::SampleIndex>(settings_.samples);
                require(sample <= trees.roots.size(), "a root a sample");
                if (trees.roots[first] & history::settled_bit) {
                    recorded.set(x, y, traced_pixel(whitted, x, y, parts, scratch));
                    continue;
                }
                for (int s = 0; s < settings_.samples; ++s) {
                    const auto root = first + static_cast<history::SampleIndex>(s);
                    const trace::Ray primary = primary_ray(x, y, s),
                                     kept = trees.ray(trees.roots[root]);
                    require(same_bits(kept.origin, primary.origin) &&
                                same_bits(kept.direction, primary.direction),
                            "a root holds its sample's primary ray");
                }
                recorded.set(x, y, recorded_pixel(scene, cell, first, parts));
            }
        require(sample == trees.roots.size(), "a root a sample");
        require(scratch.counts.rays() == trees.settled_rays,
                "settled_rays counts the rays of settled samples");
    }
    require_same(film_, recorded);
}

void Renderer::validate() const {
    const FloatState ieee;
    for (const std::unique_ptr<ViewState>& state : views_)
        if (state->film_is_current && state->view.has_history())
            state->view.validate(scene_, intersector_);
}

}  // namespace irt
