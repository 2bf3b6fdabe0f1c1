// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "arrays.h"
#include "irt/film/film.h"
#include "irt/fingerprint.h"
#include "irt/mutant.h"
#include "irt/scene/scene.h"
#include "irt/trace/intersector.h"

PYBIND11_MODULE(_core, module) {
    namespace py = pybind11;
    irt::bindings::bind_materials(module);
    irt::bindings::bind_lights(module);
    irt::bindings::bind_records(module);
    irt::bindings::bind_renderer(module);
    irt::bindings::bind_bench(module);
    py::tuple names(irt::film::aov_count);
    for (std::size_t i = 0; i < irt::film::aov_count; ++i)
        names[i] = py::str(std::string(irt::film::aov_names[i]));
    module.attr("AOVS") = names;
    module.def("numeric_fingerprint", &irt::numeric_fingerprint, py::arg("isa") = "avx2");
    module.def("name_hash", &irt::path_hash, py::arg("name"));
    module.def("versions", &irt::versions);
#ifdef IRT_MUTANTS
    module.attr("MUTANTS") = irt::mutant_names();
    module.attr("STRUCTURES") = irt::structure_names();
#endif
    module.def("best_isa", &irt::trace::best_isa);
}
