// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>

#include "arrays.h"
#include "irt/scene/change_set.h"
#include "irt/scene/curves.h"
#include "irt/scene/ribbons.h"
#include "irt/scene/subdivide.h"

namespace irt::bindings {

namespace {

using MeshPointer = std::shared_ptr<Mesh>;
using SpheresPointer = std::shared_ptr<Spheres>;
using CurvesPointer = std::shared_ptr<Curves>;
using PrototypePointer = std::shared_ptr<Prototype>;
using ArrayPointer = std::shared_ptr<InstanceArray>;
using Triple = std::array<double, 3>;

Interpolation interpolation_named(const std::string& name) {
    if (name == "constant") return Interpolation::Constant;
    if (name == "uniform") return Interpolation::Uniform;
    if (name == "varying") return Interpolation::Varying;
    if (name == "vertex") return Interpolation::Vertex;
    if (name == "faceVarying") return Interpolation::FaceVarying;
    throw py::value_error("interpolation '" + name +
                          "' is none of constant, uniform, varying, vertex, faceVarying");
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
                      const std::map<std::string, PrimvarTuple>& primvars,
                      const std::optional<Array<std::int32_t>>& face_materials,
                      const std::optional<Array<std::int32_t>>& elements) {
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
    if (face_materials) mesh->face_materials = integers(*face_materials, "face_materials");
    if (elements) mesh->elements = integers(*elements, "elements");
    return mesh;
}

std::vector<float> numbers(const Array<float>& a, const char* name) {
    if (a.ndim() != 1) throw py::value_error(std::string(name) + " must have one dimension");
    return {a.data(), a.data() + a.shape(0)};
}

SpheresPointer make_spheres(const Array<float>& points, const Array<float>& widths,
                            const std::map<std::string, PrimvarTuple>& primvars) {
    const std::vector<V3f> centres = vectors(points, "points");
    const std::vector<float> diameters = numbers(widths, "widths");
    if (diameters.size() != 1 && diameters.size() != centres.size())
        throw py::value_error("widths must be one, or one a point");
    auto spheres = std::make_shared<Spheres>();
    spheres->primvars = make_primvars(primvars);
    spheres->balls.reserve(centres.size());
    for (std::size_t i = 0; i < centres.size(); ++i)
        spheres->balls.push_back({centres[i], diameters[diameters.size() == 1 ? 0 : i] / 2});
    return spheres;
}

/// One of `names` by its place.
template <class Enum, std::size_t n>
Enum named(const std::string& name, const char* const (&names)[n], const char* what) {
    for (std::size_t i = 0; i < n; ++i)
        if (name == names[i]) return static_cast<Enum>(i);
    throw py::value_error(std::string(what) + " '" + name + "' is unknown");
}
constexpr const char* basis_names[] = {"linear", "bezier", "bspline", "catmullRom"};
constexpr const char* wrap_names[] = {"nonperiodic", "periodic", "pinned"};

ControlCurves control_curves(const Array<float>& points, const Array<std::int32_t>& vertex_counts,
                             const Array<float>& widths, const std::string& widths_interpolation,
                             const std::string& basis, const std::string& wrap,
                             const std::map<std::string, PrimvarTuple>& primvars) {
    ControlCurves curves;
    curves.basis = named<CurveBasis>(basis, basis_names, "basis");
    curves.wrap = named<CurveWrap>(wrap, wrap_names, "wrap");
    curves.points = vectors(points, "points");
    curves.vertex_counts = integers(vertex_counts, "curve_vertex_counts");
    curves.widths = numbers(widths, "widths");
    curves.widths_interpolation = interpolation_named(widths_interpolation);
    curves.primvars = make_primvars(primvars);
    return curves;
}

CurvesPointer make_curves(const Array<float>& points, const Array<std::int32_t>& vertex_counts,
                          const Array<float>& widths, const std::string& widths_interpolation,
                          const std::string& basis, const std::string& wrap, int segments,
                          const std::map<std::string, PrimvarTuple>& primvars) {
    return std::const_pointer_cast<Curves>(irt::make_curves(
        control_curves(points, vertex_counts, widths, widths_interpolation, basis, wrap, primvars),
        segments));
}

MeshPointer make_ribbons(const Array<float>& points, const Array<std::int32_t>& vertex_counts,
                         const Array<float>& widths, const Array<float>& normals,
                         const std::string& widths_interpolation,
                         const std::string& normals_interpolation, const std::string& basis,
                         const std::string& wrap, int segments,
                         const std::map<std::string, PrimvarTuple>& primvars) {
    ControlCurves curves =
        control_curves(points, vertex_counts, widths, widths_interpolation, basis, wrap, primvars);
    curves.normals = vectors(normals, "normals");
    curves.normals_interpolation = interpolation_named(normals_interpolation);
    return std::const_pointer_cast<Mesh>(irt::make_ribbons(curves, segments));
}

Geometry geometry(const py::handle& object) {
    if (py::isinstance<Quadric>(object)) return object.cast<Quadric>();
    if (py::isinstance<Mesh>(object))
        return std::shared_ptr<const Mesh>(object.cast<MeshPointer>());
    if (py::isinstance<Spheres>(object))
        return std::shared_ptr<const Spheres>(object.cast<SpheresPointer>());
    if (py::isinstance<Curves>(object))
        return std::shared_ptr<const Curves>(object.cast<CurvesPointer>());
    if (py::isinstance<Prototype>(object))
        return std::shared_ptr<const Prototype>(object.cast<PrototypePointer>());
    if (py::isinstance<InstanceArray>(object))
        return std::shared_ptr<const InstanceArray>(object.cast<ArrayPointer>());
    throw py::type_error(
        "geometry must be a Quadric, a Mesh, Spheres, Curves, a Prototype or an InstanceArray");
}

PrototypePointer make_prototype(const py::sequence& parts) {
    auto prototype = std::make_shared<Prototype>();
    for (const py::handle part : parts) {
        const auto fields = part.cast<py::tuple>();
        const auto [name, shape, transform, material, primvars, face_materials] =
            py::tuple(fields[py::slice(0, 6, 1)])
                .cast<std::tuple<std::string, py::object, Array<double>, std::string,
                                 std::map<std::string, PrimvarTuple>, std::vector<std::string>>>();
        const PassRole role = fields.size() > 6 ? fields[6].cast<PassRole>() : PassRole();
        prototype->parts.push_back({name, geometry(shape), matrix(transform), material,
                                    make_primvars(primvars), face_materials, role});
    }
    return prototype;
}

ArrayPointer make_array(const std::vector<PrototypePointer>& prototypes,
                        const Array<double>& transforms,
                        const std::optional<Array<std::int32_t>>& prototype_of,
                        const std::optional<Array<std::int64_t>>& keys,
                        const std::map<std::string, PrimvarTuple>& primvars) {
    if (transforms.ndim() != 3 || transforms.shape(1) != 4 || transforms.shape(2) != 3)
        throw py::value_error("array_from_prototype must have shape (n, 4, 3)");
    auto array = std::make_shared<InstanceArray>();
    array->prototypes.assign(prototypes.begin(), prototypes.end());
    const auto* first = reinterpret_cast<const Affine*>(transforms.data());
    array->array_from_prototype.assign(first, first + transforms.shape(0));
    if (prototype_of) {
        const std::vector<std::int32_t> indices = integers(*prototype_of, "prototype_of");
        array->prototype_of.assign(indices.begin(), indices.end());
    }
    if (keys) {
        if (keys->ndim() != 1) throw py::value_error("keys must have one dimension");
        array->keys.assign(keys->data(), keys->data() + keys->shape(0));
    }
    array->primvars = make_primvars(primvars);
    return array;
}

Quadric quadric(QuadricKind kind, double Quadric::*first, double a,
                double Quadric::*second = nullptr, double b = 0) {
    Quadric q;
    q.kind = kind;
    q.*first = a;
    if (second) q.*second = b;
    return q;
}

template <QuadricKind kind>
Quadric two_radii(double bottom, double top, double height) {
    Quadric q = quadric(kind, &Quadric::radius, bottom, &Quadric::height, height);
    q.radius_top = top;
    return q;
}

Array<float> array(const std::vector<V3f>& vectors) {
    return Array<float>({static_cast<py::ssize_t>(vectors.size()), py::ssize_t{3}},
                        reinterpret_cast<const float*>(vectors.data()));
}
Array<std::int32_t> array(const std::vector<std::int32_t>& numbers) {
    return Array<std::int32_t>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

template <class T>
T one_of(const std::string& name, const char* what,
         const std::vector<std::pair<const char*, T>>& all) {
    std::string names;
    for (const auto& [known, value] : all) {
        if (name == known) return value;
        names += std::string(names.empty() ? "" : ", ") + known;
    }
    throw py::value_error(std::string(what) + " '" + name + "' is none of " + names);
}

using Integers = Array<std::int32_t>;

std::vector<float> floats(const Array<float>& a) { return {a.data(), a.data() + a.size()}; }

Subdivider make_subdivider(const std::string& scheme, int level, const std::string& boundary,
                           const std::string& face_varying, const std::string& triangles,
                           const Integers& crease_indices, const Integers& crease_lengths,
                           const Array<float>& crease_sharpnesses, const Integers& corner_indices,
                           const Array<float>& corner_sharpnesses, const Integers& holes,
                           bool name_elements) {
    Subdivision rules;
    rules.scheme = one_of<SubdivisionScheme>(scheme, "scheme",
                                             {{"catmullClark", SubdivisionScheme::CatmullClark},
                                              {"loop", SubdivisionScheme::Loop},
                                              {"bilinear", SubdivisionScheme::Bilinear}});
    rules.level = level;
    rules.boundary = one_of<BoundaryRule>(boundary, "interpolate_boundary",
                                          {{"none", BoundaryRule::None},
                                           {"edgeOnly", BoundaryRule::EdgeOnly},
                                           {"edgeAndCorner", BoundaryRule::EdgeAndCorner}});
    rules.face_varying = one_of<FaceVaryingRule>(face_varying, "face_varying_linear_interpolation",
                                                 {{"none", FaceVaryingRule::None},
                                                  {"cornersOnly", FaceVaryingRule::CornersOnly},
                                                  {"cornersPlus1", FaceVaryingRule::CornersPlus1},
                                                  {"cornersPlus2", FaceVaryingRule::CornersPlus2},
                                                  {"boundaries", FaceVaryingRule::Boundaries},
                                                  {"all", FaceVaryingRule::All}});
    rules.smooth_triangles = one_of<bool>(triangles, "triangle_subdivision_rule",
                                          {{"catmullClark", false}, {"smooth", true}});
    rules.crease_indices = integers(crease_indices, "crease_indices");
    rules.crease_lengths = integers(crease_lengths, "crease_lengths");
    rules.crease_sharpnesses = floats(crease_sharpnesses);
    rules.corner_indices = integers(corner_indices, "corner_indices");
    rules.corner_sharpnesses = floats(corner_sharpnesses);
    rules.hole_indices = integers(holes, "hole_indices");
    rules.name_elements = name_elements;
    return Subdivider(std::move(rules));
}

void bind_geometry(py::module_& module) {
    py::class_<PassRole>(module, "PassRole")
        .def(py::init([](bool camera_visible, bool matte) {
                 return PassRole{camera_visible, matte};
             }),
             py::arg("camera_visible") = true, py::arg("matte") = false)
        .def_readonly("camera_visible", &PassRole::camera_visible)
        .def_readonly("matte", &PassRole::matte);
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
        .def_static("frustum", &two_radii<QuadricKind::Frustum>, py::arg("radius_bottom"),
                    py::arg("radius_top"), py::arg("height"))
        .def_static("round_cone", &two_radii<QuadricKind::RoundCone>, py::arg("radius_bottom"),
                    py::arg("radius_top"), py::arg("height"))
        .def_static(
            "plane",
            [](double w, double l) {
                return quadric(QuadricKind::Plane, &Quadric::width, w, &Quadric::length, l);
            },
            py::arg("width"), py::arg("length"));
    py::class_<Mesh, MeshPointer>(module, "Mesh")
        .def_property_readonly("points", [](const Mesh& m) { return array(m.points); })
        .def_property_readonly("normals", [](const Mesh& m) { return array(m.normals); })
        .def_property_readonly("face_vertex_counts",
                               [](const Mesh& m) { return array(m.face_vertex_counts); })
        .def_property_readonly("face_vertex_indices",
                               [](const Mesh& m) { return array(m.face_vertex_indices); })
        .def(py::init(&make_mesh), py::arg("points"), py::arg("face_vertex_counts"),
             py::arg("face_vertex_indices"), py::arg("normals") = py::none(),
             py::arg("normals_interpolation") = "vertex", py::arg("left_handed") = false,
             py::arg("single_sided") = false, py::arg("primvars") = py::dict(),
             py::arg("face_materials") = py::none(), py::arg("elements") = py::none())
        .def_static("ribbons", &make_ribbons, py::arg("points"), py::arg("curve_vertex_counts"),
                    py::arg("widths"), py::arg("normals"), py::kw_only(),
                    py::arg("widths_interpolation"), py::arg("normals_interpolation"),
                    py::arg("basis"), py::arg("wrap"), py::arg("segments"), py::arg("primvars"));
    py::class_<Subdivider>(module, "Subdivider")
        .def(py::init(&make_subdivider), py::kw_only(), py::arg("scheme"), py::arg("level"),
             py::arg("interpolate_boundary") = "edgeAndCorner",
             py::arg("face_varying_linear_interpolation") = "cornersPlus1",
             py::arg("triangle_subdivision_rule") = "catmullClark",
             py::arg("crease_indices") = Integers(0), py::arg("crease_lengths") = Integers(0),
             py::arg("crease_sharpnesses") = Array<float>(0),
             py::arg("corner_indices") = Integers(0),
             py::arg("corner_sharpnesses") = Array<float>(0), py::arg("hole_indices") = Integers(0),
             py::arg("name_elements") = false)
        .def(
            "refine",
            [](Subdivider& subdivider, const Mesh& cage) {
                return std::make_shared<Mesh>(subdivider.refine(cage));
            },
            py::arg("cage"))
        .def_property_readonly("left_out", &Subdivider::left_out);
    py::class_<Spheres, SpheresPointer>(module, "Spheres")
        .def(py::init(&make_spheres), py::arg("points"), py::arg("widths"),
             py::arg("primvars") = py::dict());
    py::class_<Curves, CurvesPointer>(module, "Curves")
        .def(py::init(&make_curves), py::arg("points"), py::arg("curve_vertex_counts"),
             py::arg("widths"), py::arg("widths_interpolation") = "constant",
             py::arg("basis") = "linear", py::arg("wrap") = "nonperiodic", py::arg("segments") = 8,
             py::arg("primvars") = py::dict());
    py::class_<Prototype, PrototypePointer>(module, "Prototype")
        .def(py::init(&make_prototype), py::arg("parts"));
    py::class_<InstanceArray, ArrayPointer>(module, "InstanceArray")
        .def(py::init(&make_array), py::arg("prototypes"), py::arg("array_from_prototype"),
             py::arg("prototype_of") = py::none(), py::arg("keys") = py::none(),
             py::arg("primvars") = py::dict())
        .def("__len__", &InstanceArray::size)
        .def_property_readonly("array_from_prototype", [](const py::object& self) {
            const auto& rows = self.cast<const InstanceArray&>().array_from_prototype;
            return read_only(self, rows.empty() ? nullptr : rows.front().data(),
                             {static_cast<py::ssize_t>(rows.size()), 4, 3});
        });
}

void bind_camera(py::module_& module) {
    py::class_<Camera>(module, "Camera")
        .def(
            py::init([](const Array<double>& world_from_camera, const std::array<double, 4>& window,
                        bool orthographic, const std::array<double, 2>& clipping) {
                return Camera{matrix(world_from_camera), orthographic, window, clipping[0],
                              clipping[1]};
            }),
            py::arg("world_from_camera"), py::arg("window"), py::arg("orthographic") = false,
            py::arg("clipping") =
                std::array<double, 2>{0, std::numeric_limits<double>::infinity()});
}

}  // namespace

void bind_records(py::module_& module) {
    bind_geometry(module);
    bind_camera(module);
    py::class_<ChangeSet>(module, "ChangeSet")
        .def(py::init<>())
        .def(
            "set_object",
            [](ChangeSet& c, const std::string& path, const py::object& shape,
               const Array<double>& world_from_object, const std::string& material,
               const std::map<std::string, PrimvarTuple>& primvars,
               const std::vector<std::string>& face_materials, const PassRole& role) {
                c.objects[path] = Object{geometry(shape), matrix(world_from_object),
                                         material,        make_primvars(primvars),
                                         face_materials,  role};
            },
            py::arg("path"), py::arg("geometry"), py::arg("world_from_object"),
            py::arg("material") = "", py::arg("primvars") = py::dict(),
            py::arg("face_materials") = std::vector<std::string>(), py::arg("role") = PassRole())
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
