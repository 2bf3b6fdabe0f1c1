// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "arrays.h"
#include "irt/trace_bench.h"

namespace irt::bindings {

namespace {

Loop loop_named(const std::string& name) {
    if (name == "bare") return Loop::Bare;
    if (name == "ours") return Loop::Ours;
    throw py::value_error("loop '" + name + "' is neither bare nor ours");
}

Query query_named(const std::string& name) {
    if (name == "nearest") return Query::Nearest;
    if (name == "occlusion") return Query::Occlusion;
    throw py::value_error("query '" + name + "' is neither nearest nor occlusion");
}

py::tuple time(TraceBench& bench, const std::string& loop, const std::string& query) {
    const Loop which = loop_named(loop);
    const Query what = query_named(query);
    trace::LoopTime time;
    {
        const py::gil_scoped_release release;
        time = bench.time(which, what);
    }
    return py::make_tuple(time.seconds, time.hits);
}

py::dict rays(TraceBench& bench) {
    using py::literals::operator""_a;
    const shade::Counts& counts = bench.counts();
    return py::dict("primary"_a = counts.primary, "reflected"_a = counts.reflected,
                    "refracted"_a = counts.refracted, "shadow"_a = counts.shadow);
}

}  // namespace

void bind_bench(py::module_& module) {
    using Triple = std::array<double, 3>;
    py::class_<TraceBench>(module, "TraceBench")
        .def(py::init([](const ChangeSet& scene, const Camera& camera, const ViewSettings& settings,
                         const Triple& render_origin, const std::string& isa) {
                 return std::make_unique<TraceBench>(scene, camera, settings, vec3d(render_origin),
                                                     isa);
             }),
             py::arg("scene"), py::arg("camera"), py::arg("settings"), py::kw_only(),
             py::arg("render_origin"), py::arg("isa") = "avx2",
             py::call_guard<py::gil_scoped_release>())
        .def("render", &TraceBench::render, py::arg("threads"),
             py::call_guard<py::gil_scoped_release>())
        .def("time", &time, py::arg("loop"), py::arg("query"))
        .def_property_readonly("rays", &rays)
        .def("beauty", [](const TraceBench& bench) {
            const film::Film& film = bench.film();
            return py::array_t<float>({film.height(), film.width(), 4}, film.beauty());
        });
}

}  // namespace irt::bindings
