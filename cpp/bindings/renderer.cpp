// SPDX-License-Identifier: Apache-2.0
#include "irt/renderer.h"

#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <string_view>

#include "arrays.h"

namespace irt::bindings {

namespace {

using Progress = std::function<void(double)>;

film::Aov aov_or_throw(const std::string& name) {
    if (const auto aov = film::aov_named(name)) return *aov;
    throw py::value_error("unknown AOV '" + name + "'");
}

/// The NAME of primvars:NAME.
std::optional<std::string> primvar_named(const std::string& aov) {
    constexpr std::string_view prefix = "primvars:";
    if (aov.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
    return aov.substr(prefix.size());
}

/// Name, events, whether emission counts, paths of lights or None.
using PartTuple =
    std::tuple<std::string, std::string, bool, std::optional<std::vector<std::string>>>;

shade::Events events_named(const std::string& name) {
    constexpr std::string_view names[] = {"any", "none", "once", "more", "some"};
    const auto* found = std::find(std::begin(names), std::end(names), name);
    if (found == std::end(names)) throw py::value_error("unknown events '" + name + "'");
    return static_cast<shade::Events>(found - std::begin(names));
}

/// The place of a part of the beauty, if it was asked for.
std::optional<std::size_t> part_named(const ViewSettings& settings, const std::string& name) {
    for (std::size_t p = 0; p < settings.parts.size(); ++p)
        if (settings.parts[p].name == name) return p;
    return std::nullopt;
}

ViewSettings make_settings(int width, int height, int samples, int max_depth,
                           double throughput_cutoff, double mirror_roughness,
                           const std::vector<std::string>& aovs, const std::pair<int, int>& start,
                           const std::pair<int, int>& frame, const std::vector<PartTuple>& parts) {
    ViewSettings settings;
    settings.width = width;
    settings.height = height;
    std::tie(settings.x, settings.y) = start;
    std::tie(settings.frame_width, settings.frame_height) = frame;
    settings.samples = samples;
    settings.shade = {max_depth, throughput_cutoff, mirror_roughness};
    for (const std::string& name : aovs) {
        if (const auto primvar = primvar_named(name))
            settings.primvars.push_back(*primvar);
        else
            settings.aovs.push_back(aov_or_throw(name));
    }
    for (const auto& [name, events, emission, lights] : parts)
        settings.parts.push_back({name, events_named(events), emission, lights});
    return settings;
}

std::unique_ptr<Renderer> make_renderer(const Camera& camera, const ViewSettings& settings,
                                        const std::optional<std::array<double, 3>>& render_origin,
                                        const std::string& isa, int threads, bool history,
                                        bool cost_model,
                                        const std::optional<cells::CellOrder>& cell_order,
                                        std::shared_ptr<Foreseen> foreseen) {
    RendererOptions options;
    const M44d& m = camera.world_from_camera;
    options.render_origin = render_origin ? vec3d(*render_origin) : V3d(m[3][0], m[3][1], m[3][2]);
    options.isa = isa;
    options.threads = threads;
    options.history = history;
    options.cost_model = cost_model;
    options.foreseen = std::move(foreseen);
    if (cell_order) {
        std::array<bool, cells::cell_count> seen{};
        for (const int cell : *cell_order) {
            if (cell < 0 || cell >= cells::cell_count || seen[static_cast<std::size_t>(cell)])
                throw py::value_error("cell_order must be of cells 0 to 63, each once");
            seen[static_cast<std::size_t>(cell)] = true;
        }
        if (cell_order->empty()) throw py::value_error("cell_order must name a cell");
        options.cell_order = *cell_order;
    }
    return std::make_unique<Renderer>(camera, settings, options);
}

/// Of the cells of an update: counts summed, seconds of all threads together.
py::dict statistics(const UpdateReport& report) {
    update::UpdateCounts sum;
    CellReport all;
    py::list cell_rays, cell_seconds;
    for (const CellReport& cell : report.cells) {
        sum += cell.counts;
        all.detect += cell.detect;
        all.trace += cell.trace;
        all.shade += cell.shade;
        all.combine += cell.combine;
        all.film += cell.film;
        cell_rays.append(cell.counts.rays.rays());
        cell_seconds.append(cell.detect + cell.trace + cell.shade + cell.combine + cell.film);
    }
    // Phases that run on all threads share the time by the clock as they share the processors.
    const double processor = all.detect + all.trace + all.shade + all.combine + all.film;
    const double clock = processor > 0 ? report.trace_seconds / processor : 0;
    const shade::Counts& rays = sum.rays;
    const HistorySize& history = report.history;
    using py::literals::operator""_a;
    py::dict bytes;
    for (const auto& [kind, size] : history.bytes) bytes[py::str(std::string(kind))] = size;
    return py::dict(
        "restart"_a =
            report.restart.empty() ? py::object(py::none()) : py::object(py::str(report.restart)),
        "rays"_a = py::dict("primary"_a = rays.primary, "reflected"_a = rays.reflected,
                            "refracted"_a = rays.refracted, "shadow"_a = rays.shadow),
        "all_rays"_a = report.all_rays, "flagged_rays"_a = sum.flagged,
        "tested_rays"_a = sum.tested, "retraced_rays"_a = sum.retraced,
        "changed_rays"_a = sum.changed, "new_rays"_a = sum.new_rays,
        "uncovered_rays"_a = sum.uncovered, "whole_scene_rays"_a = sum.whole_scene,
        "nodes_traversed"_a = sum.nodes_traversed, "intersections"_a = rays.queries.candidates,
        "shadings"_a = rays.shadings,
        "history"_a = py::dict("nodes"_a = history.nodes, "points"_a = history.points,
                               "all_bytes"_a = history.all_bytes(), "bytes"_a = bytes),
        "seconds"_a = py::dict("apply"_a = report.apply_seconds, "bvh"_a = report.bvh_seconds,
                               "detect"_a = report.plan_seconds + clock * all.detect,
                               "trace"_a = processor > 0 ? clock * all.trace : report.trace_seconds,
                               "shade"_a = clock * all.shade, "combine"_a = clock * all.combine,
                               "film"_a = clock * all.film,
                               "total"_a = report.apply_seconds + report.bvh_seconds +
                                           report.plan_seconds + report.trace_seconds),
        "cells"_a = py::dict("rays"_a = cell_rays, "seconds"_a = cell_seconds));
}

/// Runs the update beside the interpreter's thread, which goes on to poll signals and report.
std::vector<UpdateReport> run_update(Renderer& renderer, const ChangeSet& changes,
                                     const std::vector<ViewUpdate>& views,
                                     const std::optional<Progress>& progress) {
    constexpr std::chrono::milliseconds poll{50};
    cells::Control control;
    auto running =
        std::async(std::launch::async, [&] { return renderer.update(changes, views, control); });
    bool interrupted = false;
    for (auto state = std::future_status::timeout; state != std::future_status::ready;) {
        if (!interrupted) {
            interrupted = PyErr_CheckSignals() != 0;
            // Not before the first step: until then the update may not have begun.
            if (!interrupted && progress && control.steps_done > 0) {
                try {
                    (*progress)(control.progress());
                } catch (py::error_already_set& error) {
                    error.restore();
                    interrupted = true;
                }
            }
            if (interrupted) control.stop = true;
        }
        const py::gil_scoped_release release;
        state = running.wait_for(poll);
    }
    std::vector<UpdateReport> reports = running.get();
    if (interrupted) throw py::error_already_set();
    return reports;
}

const film::Film& film_of(const Renderer& renderer, std::size_t view) {
    if (view >= renderer.view_count()) throw py::index_error("no such view");
    return renderer.film(view);
}

py::array aov_array(const py::object& self, const std::string& name, std::size_t view) {
    using film::Aov;
    const Renderer& renderer = self.cast<const Renderer&>();
    const film::Film& film = film_of(renderer, view);
    const py::ssize_t height = film.height(), width = film.width();
    if (const auto primvar = primvar_named(name)) {
        const std::vector<std::string>& asked = renderer.settings(view).primvars;
        const auto found = std::find(asked.begin(), asked.end(), *primvar);
        if (found == asked.end()) throw py::value_error("AOV '" + name + "' was not asked for");
        const auto index = static_cast<std::size_t>(found - asked.begin());
        return read_only(self, film.primvar(index)->data(), {height, width, 4});
    }
    if (const auto part = part_named(renderer.settings(view), name))
        return read_only(self, &film.part(*part)->x, {height, width, 3});
    const Aov aov = aov_or_throw(name);
    if (!film.has(aov)) throw py::value_error("AOV '" + name + "' was not asked for");
    switch (aov) {
        case Aov::Depth:
            return read_only(self, film.depth(), {height, width});
        case Aov::Retraced:
            return read_only(self, film.retraced(), {height, width});
        case Aov::ObjectId:
        case Aov::InstanceId:
        case Aov::ElementId:
            return read_only(self, film.ids(aov), {height, width});
        case Aov::CryptoObject:
        case Aov::CryptoMaterial: {
            const auto* pixels = reinterpret_cast<const std::uint32_t*>(film.coverage(aov));
            return read_only(self, pixels,
                             {height, width, static_cast<py::ssize_t>(film.ranks()), 2});
        }
        case Aov::Cause:
            return read_only(self, film.causes(), {height, width});
        case Aov::Seen:
            throw py::value_error("irt.seen is no picture");
        default:
            return read_only(self, &film.vectors(aov)->x, {height, width, 3});
    }
}

py::dict pixel_values(const Renderer& renderer, int x, int y, std::size_t view) {
    const film::Film& film = film_of(renderer, view);
    if (x < 0 || y < 0 || x >= film.width() || y >= film.height())
        throw py::index_error("no such pixel");
    const film::PixelValue value = renderer.brute_force_pixel(x, y, view);
    const auto vector = [](const V3f& v) { return py::array_t<float>(3, &v.x); };
    py::dict out;
    out["beauty"] = py::array_t<float>(4, value.rgba);
    if (film.has(film::Aov::Depth)) out["depth"] = py::array_t<float>(1, &value.depth);
    if (film.has(film::Aov::Normal)) out["normal"] = vector(value.normal);
    if (film.has(film::Aov::Position)) out["position"] = vector(value.position);
    if (film.has(film::Aov::Albedo)) out["albedo"] = vector(value.albedo);
    if (film.has(film::Aov::ObjectId))
        out["objectId"] = py::array_t<std::uint32_t>(1, &value.object_id);
    if (film.has(film::Aov::InstanceId))
        out["instanceId"] = py::array_t<std::uint32_t>(1, &value.instance_id);
    if (film.has(film::Aov::ElementId))
        out["elementId"] = py::array_t<std::uint32_t>(1, &value.element_id);
    const auto coverage = [&](const film::Ranks& ranks) {
        return py::array_t<std::uint32_t>({static_cast<py::ssize_t>(film.ranks()), py::ssize_t{2}},
                                          reinterpret_cast<const std::uint32_t*>(ranks.data()));
    };
    if (film.has(film::Aov::CryptoObject)) out["CryptoObject"] = coverage(value.objects);
    if (film.has(film::Aov::CryptoMaterial)) out["CryptoMaterial"] = coverage(value.materials);
    const std::vector<std::string>& primvars = renderer.settings(view).primvars;
    for (std::size_t p = 0; p < primvars.size(); ++p) {
        const std::array<float, 4> none{};
        const float* pixel = p < value.primvars.size() ? value.primvars[p].data() : none.data();
        out[py::str("primvars:" + primvars[p])] = py::array_t<float>(4, pixel);
    }
    for (std::size_t p = 0; p < value.parts.size(); ++p)
        out[py::str(renderer.settings(view).parts[p].name)] = vector(value.parts[p]);
    return out;
}

}  // namespace

void bind_renderer(py::module_& module) {
    const ViewSettings d;
    py::class_<ViewSettings>(module, "ViewSettings")
        .def(py::init(&make_settings), py::arg("width"), py::arg("height"),
             py::arg("samples") = d.samples, py::arg("max_depth") = d.shade.max_depth,
             py::arg("throughput_cutoff") = d.shade.throughput_cutoff,
             py::arg("mirror_roughness") = d.shade.mirror_roughness,
             py::arg("aovs") = std::vector<std::string>{}, py::arg("start") = std::pair(0, 0),
             py::arg("frame") = std::pair(0, 0), py::arg("parts") = std::vector<PartTuple>{});
    py::class_<Foreseen, std::shared_ptr<Foreseen>>(module, "Foreseen")
        .def(py::init<const ChangeSet&>(), py::arg("initial"))
        .def("add", &Foreseen::add, py::arg("changes"));
    py::class_<Renderer> renderer(module, "Renderer");
    renderer
        .def(py::init(&make_renderer), py::arg("camera"), py::arg("settings"), py::kw_only(),
             py::arg("render_origin") = py::none(), py::arg("isa") = "avx2", py::arg("threads") = 0,
             py::arg("history") = true, py::arg("cost_model") = true,
             py::arg("cell_order") = py::none(), py::arg("foreseen") = py::none())
        .def(
            "update",
            [](Renderer& renderer, const ChangeSet& changes, const std::optional<Camera>& camera,
               const std::optional<Progress>& progress, bool keep_history,
               const std::vector<std::pair<std::optional<Camera>, bool>>& more_views) {
                std::vector<ViewUpdate> views{{camera, keep_history}};
                for (const auto& [its_camera, keep] : more_views)
                    views.push_back({its_camera, keep});
                const std::vector<UpdateReport> reports =
                    run_update(renderer, changes, views, progress);
                py::dict first = statistics(reports[0]);
                py::list more;
                for (std::size_t v = 1; v < reports.size(); ++v)
                    more.append(statistics(reports[v]));
                first["more_views"] = more;
                return first;
            },
            py::arg("changes"), py::arg("camera") = py::none(), py::arg("on_progress") = py::none(),
            py::kw_only(), py::arg("keep_history") = true,
            py::arg("more_views") = std::vector<std::pair<std::optional<Camera>, bool>>{})
        .def("add_view", &Renderer::add_view, py::arg("camera"), py::arg("settings"))
        .def(
            "beauty",
            [](const py::object& self, std::size_t view) {
                const film::Film& film = film_of(self.cast<const Renderer&>(), view);
                return read_only(self, film.beauty(), {film.height(), film.width(), 4});
            },
            py::arg("view") = 0)
        .def("aov", &aov_array, py::arg("name"), py::arg("view") = 0)
        .def(
            "motion",
            [](const Renderer& renderer, const ChangeSet& changes,
               const std::optional<Camera>& camera, std::size_t view) {
                const film::Film& film = film_of(renderer, view);
                const std::vector<V2f> motion = renderer.motion(changes, camera, view);
                return py::array_t<float>({film.height(), film.width(), 2}, &motion.data()->x);
            },
            py::arg("changes"), py::arg("camera") = py::none(), py::arg("view") = 0)
        .def("cause_name", &Renderer::cause_name, py::arg("cause"))
        .def(
            "names",
            [](const Renderer& renderer, const std::string& aov, std::set<std::uint32_t> ids) {
                return renderer.names(aov_or_throw(aov), std::move(ids));
            },
            py::arg("aov"), py::arg("ids"))
        .def("brute_force_pixel", &pixel_values, py::arg("x"), py::arg("y"), py::arg("view") = 0)
        .def("validate", &Renderer::validate);
    bind_checkpoint(module, renderer);
}

}  // namespace irt::bindings
