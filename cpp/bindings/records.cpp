// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "arrays.h"
#include "irt/scene/change_set.h"

namespace irt::bindings {

namespace {

using MeshPointer = std::shared_ptr<Mesh>;
using PrototypePointer = std::shared_ptr<Prototype>;
using Triple = std::array<double, 3>;

Interpolation interpolation_named(const std::string& name) {
    if (name == "constant") return Interpolation::Constant;
    if (name == "uniform") return Interpolation::Uniform;
    if (name == "vertex") return Interpolation::Vertex;
    if (name == "faceVarying") return Interpolation::FaceVarying;
    throw py::value_error("interpolation '" + name +
                          "' is none of constant, uniform, vertex, faceVarying");
}

using PrimvarTuple = std::tuple<std::string, Array<float>, std::optional<Array<std::int32_t>>>;

/// {name: (interpolation, values (n, w) float32, indices int32 or None)}.
Primvars make_primvars(const std::map<std::string, PrimvarTuple>& named) {
    Primvars primvars;
    for (const auto& [name, primvar] : named) {
        const auto& [interpolation, values, indices] = primvar;
        if (values.ndim() != 2 || values.shape(1) < 1 || values.shape(1) > 4)
            throw py::value_error("primvar " + name + " must have shape (n, 1) to (n, 4)");
        Primvar& out = primvars.emplace_back();
        out.name = name;
        out.interpolation = interpolation_named(interpolation);
        out.width = static_cast<int>(values.shape(1));
        out.values.assign(values.data(), values.data() + values.size());
        if (indices) out.indices = integers(*indices, name.c_str());
    }
    return primvars;
}

MeshPointer make_mesh(const Array<float>& points, const Array<std::int32_t>& counts,
                      const Array<std::int32_t>& indices,
                      const std::optional<Array<float>>& normals, const std::string& interpolation,
                      bool left_handed, bool single_sided,
                      const std::map<std::string, PrimvarTuple>& primvars) {
    auto mesh = std::make_shared<Mesh>();
    mesh->points = vectors(points, "points");
    mesh->face_vertex_counts = integers(counts, "face_vertex_counts");
    mesh->face_vertex_indices = integers(indices, "face_vertex_indices");
    if (normals) {
        mesh->normals = vectors(*normals, "normals");
        mesh->normals_interpolation = interpolation_named(interpolation);
    }
    mesh->left_handed = left_handed;
    mesh->single_sided = single_sided;
    mesh->primvars = make_primvars(primvars);
    return mesh;
}

Geometry geometry(const py::handle& object) {
    if (py::isinstance<Quadric>(object)) return object.cast<Quadric>();
    if (py::isinstance<Mesh>(object))
        return std::shared_ptr<const Mesh>(object.cast<MeshPointer>());
    if (py::isinstance<Prototype>(object))
        return std::shared_ptr<const Prototype>(object.cast<PrototypePointer>());
    throw py::type_error("geometry must be a Quadric, a Mesh or a Prototype");
}

PrototypePointer make_prototype(const py::sequence& parts) {
    auto prototype = std::make_shared<Prototype>();
    for (const py::handle part : parts) {
        const auto [name, shape, transform, material] =
            part.cast<std::tuple<std::string, py::object, Array<double>, std::string>>();
        prototype->parts.push_back({name, geometry(shape), matrix(transform), material});
    }
    return prototype;
}

Quadric quadric(QuadricKind kind, double Quadric::*first, double a,
                double Quadric::*second = nullptr, double b = 0) {
    Quadric q;
    q.kind = kind;
    q.*first = a;
    if (second) q.*second = b;
    return q;
}

void bind_geometry(py::module_& module) {
    py::class_<Quadric>(module, "Quadric")
        .def_static(
            "sphere", [](double r) { return quadric(QuadricKind::Sphere, &Quadric::radius, r); },
            py::arg("radius"))
        .def_static(
            "cube", [](double s) { return quadric(QuadricKind::Cube, &Quadric::size, s); },
            py::arg("size"))
        .def_static(
            "cylinder",
            [](double r, double h) {
                return quadric(QuadricKind::Cylinder, &Quadric::radius, r, &Quadric::height, h);
            },
            py::arg("radius"), py::arg("height"))
        .def_static(
            "cone",
            [](double r, double h) {
                return quadric(QuadricKind::Cone, &Quadric::radius, r, &Quadric::height, h);
            },
            py::arg("radius"), py::arg("height"))
        .def_static(
            "capsule",
            [](double r, double h) {
                return quadric(QuadricKind::Capsule, &Quadric::radius, r, &Quadric::height, h);
            },
            py::arg("radius"), py::arg("height"))
        .def_static(
            "plane",
            [](double w, double l) {
                return quadric(QuadricKind::Plane, &Quadric::width, w, &Quadric::length, l);
            },
            py::arg("width"), py::arg("length"));
    py::class_<Mesh, MeshPointer>(module, "Mesh")
        .def(py::init(&make_mesh), py::arg("points"), py::arg("face_vertex_counts"),
             py::arg("face_vertex_indices"), py::arg("normals") = py::none(),
             py::arg("normals_interpolation") = "vertex", py::arg("left_handed") = false,
             py::arg("single_sided") = false, py::arg("primvars") = py::dict());
    py::class_<Prototype, PrototypePointer>(module, "Prototype")
        .def(py::init(&make_prototype), py::arg("parts"));
}

void bind_light_and_camera(py::module_& module) {
    py::class_<Light>(module, "Light")
        .def_static(
            "distant",
            [](const Triple& direction, const Triple& irradiance, bool shadows) {
                Light light;
                light.kind = LightKind::Distant;
                light.direction = vec3d(direction);
                light.energy = vec3f(irradiance);
                light.casts_shadows = shadows;
                return light;
            },
            py::arg("direction"), py::arg("irradiance"), py::arg("casts_shadows") = true)
        .def_static(
            "point",
            [](const Triple& position, const Triple& intensity, bool shadows) {
                Light light;
                light.kind = LightKind::Point;
                light.position = vec3d(position);
                light.energy = vec3f(intensity);
                light.casts_shadows = shadows;
                return light;
            },
            py::arg("position"), py::arg("intensity"), py::arg("casts_shadows") = true);
    py::class_<Camera>(module, "Camera")
        .def(py::init([](const Array<double>& world_from_camera,
                         const std::array<double, 4>& window, bool orthographic) {
                 return Camera{matrix(world_from_camera), orthographic, window};
             }),
             py::arg("world_from_camera"), py::arg("window"), py::arg("orthographic") = false);
}

}  // namespace

void bind_records(py::module_& module) {
    bind_geometry(module);
    bind_light_and_camera(module);
    py::class_<ChangeSet>(module, "ChangeSet")
        .def(py::init<>())
        .def(
            "set_object",
            [](ChangeSet& c, const std::string& path, const py::object& shape,
               const Array<double>& world_from_object, const std::string& material,
               const std::map<std::string, PrimvarTuple>& primvars) {
                c.objects[path] = Object{geometry(shape), matrix(world_from_object), material,
                                         make_primvars(primvars)};
            },
            py::arg("path"), py::arg("geometry"), py::arg("world_from_object"),
            py::arg("material") = "", py::arg("primvars") = py::dict())
        .def(
            "remove_object", [](ChangeSet& c, const std::string& path) { c.objects[path].reset(); },
            py::arg("path"))
        .def(
            "set_material",
            [](ChangeSet& c, const std::string& name, const Material& m) { c.materials[name] = m; },
            py::arg("name"), py::arg("material"))
        .def(
            "remove_material",
            [](ChangeSet& c, const std::string& name) { c.materials[name].reset(); },
            py::arg("name"))
        .def(
            "set_light",
            [](ChangeSet& c, const std::string& path, const Light& l) { c.lights[path] = l; },
            py::arg("path"), py::arg("light"))
        .def(
            "remove_light", [](ChangeSet& c, const std::string& path) { c.lights[path].reset(); },
            py::arg("path"))
        .def_property_readonly("empty", &ChangeSet::empty);
}

}  // namespace irt::bindings
