// SPDX-License-Identifier: Apache-2.0
// Lights, and what they are made of.
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include "arrays.h"
#include "irt/scene/mesh_light.h"
#include "irt/scene/sky.h"
#include "irt/texture/rows.h"

namespace irt::bindings {

namespace {

using Triple = std::array<double, 3>;
using Axes = std::array<Triple, 3>;
using TexturePointer = std::shared_ptr<Texture>;

Profile profile_named(const std::string& name) {
    if (name == "uniform") return Profile::Uniform;
    if (name == "facing") return Profile::Facing;
    if (name == "round") return Profile::Round;
    if (name == "facets") return Profile::Facets;
    throw py::value_error("profile '" + name + "' is none of uniform, facing, round, facets");
}

std::shared_ptr<const IesWeb> make_web(const py::handle& value) {
    auto web = std::make_shared<IesWeb>();
    std::tie(web->vertical, web->horizontal, web->values) =
        value.cast<std::tuple<std::vector<float>, std::vector<float>, std::vector<float>>>();
    if (web->vertical.empty() || web->horizontal.empty() ||
        web->values.size() != web->vertical.size() * web->horizontal.size())
        throw py::value_error("ies: as many values as pairs of angles, one at least");
    return web;
}

/// (n, 6) float32: area and offset of each.
std::vector<Facet> make_facets(const Array<float>& values) {
    if (values.ndim() != 2 || values.shape(1) != 6)
        throw py::value_error("facets must have shape (n, 6)");
    const auto* first = reinterpret_cast<const Facet*>(values.data());
    return {first, first + values.shape(0)};
}

/// Sets what is given by name of a light's further fields.
void modify(Light& light, const py::dict& modifiers) {
    for (const auto& [key, value] : modifiers) {
        const auto name = key.cast<std::string>();
        if (name == "profile")
            light.profile = profile_named(value.cast<std::string>());
        else if (name == "axis")
            light.direction = vec3d(value.cast<Triple>());
        else if (name == "side")
            light.side = vec3d(value.cast<Triple>());
        else if (name == "diffuse")
            light.diffuse = value.cast<float>();
        else if (name == "specular")
            light.specular = value.cast<float>();
        else if (name == "cone_angle")
            light.cone_angle = value.cast<float>();
        else if (name == "cone_softness")
            light.cone_softness = value.cast<float>();
        else if (name == "focus")
            light.focus = value.cast<float>();
        else if (name == "focus_tint")
            light.focus_tint = vec3f(value.cast<Triple>());
        else if (name == "ies")
            light.ies = make_web(value);
        else if (name == "shadow_color")
            light.shadow_color = vec3f(value.cast<Triple>());
        else if (name == "shadow_distance")
            light.shadow_distance = value.cast<float>();
        else if (name == "unlit")
            light.unlit = value.cast<std::vector<std::string>>();
        else if (name == "shadowless")
            light.shadowless = value.cast<std::vector<std::string>>();
        else if (name == "shadow_falloff")
            light.shadow_falloff = value.cast<float>();
        else if (name == "shadow_falloff_gamma")
            light.shadow_falloff_gamma = value.cast<float>();
        else if (name == "facets")
            light.facets = make_facets(value.cast<Array<float>>());
        else
            throw py::value_error("a light has no '" + name + "'");
    }
    std::sort(light.unlit.begin(), light.unlit.end());
    std::sort(light.shadowless.begin(), light.shadowless.end());
}

Light make_distant(const Triple& direction, const Triple& irradiance, bool shadows,
                   const py::dict& modifiers) {
    Light light;
    light.direction = vec3d(direction);
    light.energy = vec3f(irradiance);
    light.casts_shadows = shadows;
    modify(light, modifiers);
    return light;
}

Light make_point(const Triple& position, const Triple& intensity, bool shadows,
                 const py::dict& modifiers) {
    Light light;
    light.kind = LightKind::Point;
    light.position = vec3d(position);
    light.energy = vec3f(intensity);
    light.casts_shadows = shadows;
    modify(light, modifiers);
    return light;
}

Light make_environment(const Triple& radiance, bool camera_visible, const TexturePointer& texture,
                       const Axes& axes) {
    Light light;
    light.camera_visible = camera_visible;
    light.kind = LightKind::Environment;
    light.energy = vec3f(radiance);
    light.casts_shadows = false;
    if (texture)
        light.sky =
            std::make_shared<Sky>(Sky{texture, vec3d(axes[0]), vec3d(axes[1]), vec3d(axes[2])});
    return light;
}

std::vector<Triple> triples(const std::vector<V3d>& vectors) {
    std::vector<Triple> out;
    for (const V3d& v : vectors) out.push_back({v.x, v.y, v.z});
    return out;
}

}  // namespace

void bind_lights(py::module_& module) {
    constexpr Axes world{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    py::class_<Light>(module, "Light")
        .def_static("distant", &make_distant, py::arg("direction"), py::arg("irradiance"),
                    py::arg("casts_shadows") = true, py::kw_only(),
                    py::arg("modifiers") = py::dict())
        .def_static("point", &make_point, py::arg("position"), py::arg("intensity"),
                    py::arg("casts_shadows") = true, py::kw_only(),
                    py::arg("modifiers") = py::dict())
        .def_static("environment", &make_environment, py::arg("radiance"),
                    py::arg("camera_visible") = true, py::arg("texture") = py::none(),
                    py::arg("axes") = world);
    module.def(
        "sky_directions",
        [](int count, const Triple& up) { return triples(sky_directions(count, vec3d(up))); },
        py::arg("count"), py::arg("up"));
    py::class_<SkyCells>(module, "SkyCells")
        .def(py::init([](const Texture& texture) { return SkyCells(texture); }), py::arg("texture"),
             py::call_guard<py::gil_scoped_release>())
        .def(
            "irradiances",
            [](const SkyCells& cells, const Axes& axes, const std::vector<Triple>& directions) {
                std::vector<V3d> ways;
                for (const Triple& direction : directions) ways.push_back(vec3d(direction));
                return triples(
                    cells.irradiances(vec3d(axes[0]), vec3d(axes[1]), vec3d(axes[2]), ways));
            },
            py::arg("axes"), py::arg("directions"));
    module.def(
        "texture_mean",
        [](const Texture& texture) {
            const V3d mean = texture::mean(texture);
            return Triple{mean.x, mean.y, mean.z};
        },
        py::arg("texture"), py::call_guard<py::gil_scoped_release>());
    module.def(
        "mesh_light",
        [](const std::shared_ptr<Mesh>& mesh, const Array<double>& world_from_object,
           const std::string& path) {
            const MeshLight light = make_mesh_light(mesh, matrix(world_from_object), path);
            Array<float> facets({light.facets.size(), std::size_t{6}});
            std::copy(light.facets.begin(), light.facets.end(),
                      reinterpret_cast<Facet*>(facets.mutable_data()));
            return std::tuple(Triple{light.centre.x, light.centre.y, light.centre.z}, light.area,
                              facets);
        },
        py::arg("mesh"), py::arg("world_from_object"), py::arg("path"));
}

}  // namespace irt::bindings
