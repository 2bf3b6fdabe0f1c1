// SPDX-License-Identifier: Apache-2.0
// numpy arrays and sequences to the core's records.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

#include "irt/math/vec.h"

namespace irt {
class Renderer;
}

namespace irt::bindings {

namespace py = pybind11;

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

inline V3f vec3f(const std::array<double, 3>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}
inline V3d vec3d(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// (4, 4) float64, row vectors.
inline M44d matrix(const Array<double>& a) {
    if (a.ndim() != 2 || a.shape(0) != 4 || a.shape(1) != 4)
        throw py::value_error("a transform must have shape (4, 4)");
    M44d m;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) m[i][j] = a.at(i, j);
    return m;
}

/// (n, 3) float32.
inline std::vector<V3f> vectors(const Array<float>& a, const char* name) {
    if (a.ndim() != 2 || a.shape(1) != 3)
        throw py::value_error(std::string(name) + " must have shape (n, 3)");
    const auto* first = reinterpret_cast<const V3f*>(a.data());
    return {first, first + a.shape(0)};
}

inline std::vector<std::int32_t> integers(const Array<std::int32_t>& a, const char* name) {
    if (a.ndim() != 1) throw py::value_error(std::string(name) + " must have one dimension");
    return {a.data(), a.data() + a.shape(0)};
}

/// A read-only view of `data`, kept alive by `owner`.
template <class T>
py::array read_only(const py::object& owner, const T* data, std::vector<py::ssize_t> shape) {
    py::array_t<T> array(std::move(shape), data, owner);
    array.attr("flags").attr("writeable") = false;
    return array;
}

void bind_materials(py::module_& module);
void bind_records(py::module_& module);
void bind_lights(py::module_& module);
void bind_renderer(py::module_& module);
void bind_checkpoint(py::module_& module, py::class_<Renderer>& renderer);
void bind_bench(py::module_& module);

}  // namespace irt::bindings
