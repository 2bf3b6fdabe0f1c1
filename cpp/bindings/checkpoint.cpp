// SPDX-License-Identifier: Apache-2.0
#include "irt/checkpoint/file.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <system_error>

#include "arrays.h"
#include "irt/renderer.h"

namespace irt::bindings {

namespace {

using checkpoint::ArrayEntry;
using checkpoint::ArrayWriter;
using checkpoint::BackgroundWrite;
using checkpoint::MappedFile;

[[noreturn]] void raise_os_error(int error, const std::string& path) {
    errno = error;
    PyErr_SetFromErrnoWithFilename(PyExc_OSError, path.c_str());
    throw py::error_already_set();
}

/// Calls `body`; what the system refuses becomes Python's OSError.
template <class Body>
auto telling_os_errors(const std::string& path, Body&& body) {
    try {
        return body();
    } catch (const std::system_error& error) {
        raise_os_error(error.code().value(), path);
    }
}

void add_array(ArrayWriter& arrays, const std::string& name, const py::array& array) {
    if (!(array.flags() & py::array::c_style))
        throw py::value_error(name + ": the array is not contiguous");
    const auto dtype = py::str(array.dtype().attr("str")).cast<std::string>();
    const auto size = static_cast<std::size_t>(array.nbytes());
    const auto* bytes = static_cast<const std::byte*>(array.data());
    const std::vector<std::byte>& kept = arrays.keep(std::vector<std::byte>(bytes, bytes + size));
    arrays.add(name, dtype, static_cast<std::size_t>(array.itemsize()),
               static_cast<std::size_t>(array.size()), {std::span<const std::byte>(kept)});
}

py::list directory(const ArrayWriter& arrays) {
    py::list entries;
    for (const ArrayEntry& entry : arrays.entries())
        entries.append(
            py::make_tuple(entry.name, entry.type, entry.item_size, entry.count, entry.offset));
    return entries;
}

void write(const ArrayWriter& arrays, const std::string& path, const std::string& header) {
    int error = 0;
    {
        const py::gil_scoped_release release;
        error = checkpoint::write(path, header, arrays.entries(), arrays.size());
    }
    if (error != 0) raise_os_error(error, path);
}

py::array mapped_data(const py::object& self) {
    const std::span<const std::byte> data = self.cast<const MappedFile&>().data();
    return read_only(self, reinterpret_cast<const std::uint8_t*>(data.data()),
                     {static_cast<py::ssize_t>(data.size())});
}

using Directory = std::map<std::string, std::tuple<std::size_t, std::size_t, std::size_t>>;

void restore(Renderer& renderer, const ChangeSet& scene, const MappedFile& file,
             const Directory& arrays) {
    std::map<std::string, checkpoint::ArrayReader::Stored> stored;
    const std::span<const std::byte> data = file.data();
    for (const auto& [name, place] : arrays) {
        const auto& [item_size, count, offset] = place;
        if (offset > data.size() || item_size == 0 || count > (data.size() - offset) / item_size)
            throw std::runtime_error(name + ": lies outside the file");
        stored[name] = {data.subspan(offset, item_size * count), item_size};
    }
    const py::gil_scoped_release release;
    checkpoint::ArrayReader reader(std::move(stored));
    renderer.restore(scene, reader);
}

}  // namespace

void bind_checkpoint(py::module_& module, py::class_<Renderer>& renderer) {
    py::class_<ArrayWriter>(module, "ArrayWriter")
        .def(py::init<>())
        .def("add", &add_array, py::arg("name"), py::arg("array"))
        .def("directory", &directory)
        .def("size", &ArrayWriter::size)
        .def("write", &write, py::arg("path"), py::arg("header"))
        .def(
            "write_in_background",
            [](const ArrayWriter& arrays, const std::string& path, const std::string& header) {
                return telling_os_errors(path, [&] {
                    return std::make_unique<BackgroundWrite>(path, header, arrays.entries(),
                                                             arrays.size());
                });
            },
            py::arg("path"), py::arg("header"));
    py::class_<BackgroundWrite>(module, "BackgroundWrite")
        .def("done", &BackgroundWrite::done)
        .def("cancel", &BackgroundWrite::cancel)
        .def("result", &BackgroundWrite::result);
    py::class_<MappedFile>(module, "MappedFile")
        .def(py::init([](const std::string& path) {
                 return telling_os_errors(path, [&] { return std::make_unique<MappedFile>(path); });
             }),
             py::arg("path"))
        .def("header",
             [](const MappedFile& file) {
                 return py::bytes(file.header().data(), file.header().size());
             })
        .def("data", &mapped_data)
        .def("damaged", &MappedFile::damaged, py::arg("threads") = 0,
             py::call_guard<py::gil_scoped_release>());
    module.attr("CHECKPOINT_BLOCK") = checkpoint::block;
    module.def(
        "file_hash",
        [](const std::string& path) {
            return telling_os_errors(path, [&] {
                const py::gil_scoped_release release;
                return checkpoint::file_hash(path);
            });
        },
        py::arg("path"));
    module.def(
        "bytes_hash",
        [](const py::bytes& bytes) { return checkpoint::bytes_hash(std::string_view(bytes)); },
        py::arg("data"));
    renderer.def("save", &Renderer::save, py::arg("arrays"))
        .def("restore", &restore, py::arg("scene"), py::arg("file"), py::arg("arrays"));
}

}  // namespace irt::bindings
