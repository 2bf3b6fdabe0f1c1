// SPDX-License-Identifier: Apache-2.0
// Materials, their graphs and textures.
#include <pybind11/stl.h>

#include <algorithm>
#include <map>

#include "arrays.h"
#include "irt/scene/material.h"

namespace irt::bindings {

namespace {

using Triple = std::array<double, 3>;

/// The place of `name` among `names`; py::value_error naming `what` where it is none.
template <class Names>
std::size_t place_of(const Names& names, const std::string& name, const char* what) {
    const auto found = std::find(std::begin(names), std::end(names), name);
    if (found == std::end(names))
        throw py::value_error(std::string(what) + " '" + name + "' is unknown");
    return static_cast<std::size_t>(found - std::begin(names));
}

// ---- textures

TexelFormat format_of(const py::array& texels) {
    const char kind = texels.dtype().kind();
    const py::ssize_t size = texels.itemsize();
    if (kind == 'u' && size == 1) return TexelFormat::U8;
    if (kind == 'u' && size == 2) return TexelFormat::U16;
    if (kind == 'f' && size == 2) return TexelFormat::Half;
    if (kind == 'f' && size == 4) return TexelFormat::Float;
    throw py::value_error("texels must be uint8, uint16, float16 or float32");
}

/// The array's memory, which lives as long as anybody looks at it.
std::shared_ptr<const std::byte> shared_memory(const py::array& array) {
    auto* const owner = new py::object(array);
    return {static_cast<const std::byte*>(array.data()), [owner](const std::byte*) {
                if (!Py_IsInitialized()) return;  // it went with the interpreter
                const py::gil_scoped_acquire gil;
                delete owner;
            }};
}

Tile make_tile(int u, int v, const py::array& given) {
    const py::array texels = py::array::ensure(given, py::array::c_style);
    if (!texels || (texels.ndim() != 2 && texels.ndim() != 3))
        throw py::value_error(
            "texels must have shape (height, width) or (height, width, channels)");
    Tile tile;
    tile.u = u;
    tile.v = v;
    tile.format = format_of(texels);
    tile.channels = texels.ndim() == 3 ? static_cast<int>(texels.shape(2)) : 1;
    tile.levels.push_back({static_cast<int>(texels.shape(1)), static_cast<int>(texels.shape(0)),
                           shared_memory(texels)});
    return tile;
}

std::shared_ptr<Texture> make_texture(const std::vector<std::tuple<int, int, py::array>>& given,
                                      const std::string& transfer,
                                      const std::optional<Array<double>>& matrix, bool udim) {
    std::vector<Tile> tiles;
    for (const auto& [u, v, texels] : given) tiles.push_back(make_tile(u, v, texels));
    std::array<double, 9> rows{1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (matrix) {
        if (matrix->ndim() != 2 || matrix->shape(0) != 3 || matrix->shape(1) != 3)
            throw py::value_error("matrix must have shape (3, 3)");
        std::copy(matrix->data(), matrix->data() + rows.size(), rows.begin());
    }
    static constexpr std::array names{"linear", "srgb"};
    const auto decoded = static_cast<Transfer>(place_of(names, transfer, "transfer"));
    const py::gil_scoped_release no_gil;
    return std::make_shared<Texture>(std::move(tiles), decoded, rows, udim);
}

void bind_texture(py::module_& module) {
    py::class_<Texture, std::shared_ptr<Texture>>(module, "Texture")
        .def(py::init(&make_texture), py::arg("tiles"), py::kw_only(),
             py::arg("transfer") = "linear", py::arg("matrix") = py::none(),
             py::arg("udim") = false)
        .def(
            "without_finest",
            [](const Texture& texture, std::size_t count) {
                return std::make_shared<Texture>(texture.without_finest(count));
            },
            py::arg("count"))
        .def_property_readonly("level_bytes", &Texture::level_bytes);
}

// ---- nodes

/// A number for all four components, or up to four: missing ones are 0, the fourth 1.
std::array<float, 4> constant(const py::handle& given) {
    if (py::isinstance<py::float_>(given) || py::isinstance<py::int_>(given)) {
        const auto value = given.cast<float>();
        return {value, value, value, value};
    }
    const auto values = given.cast<std::vector<float>>();
    if (values.size() > 4) throw py::value_error("a constant has at most 4 components");
    std::array<float, 4> out{0, 0, 0, 1};
    std::copy(values.begin(), values.end(), out.begin());
    return out;
}

std::shared_ptr<ShadeNode> make_node(const std::string& op, const std::vector<std::int32_t>& inputs,
                                     const py::sequence& constants, const std::string& primvar,
                                     std::shared_ptr<Texture> texture,
                                     const std::pair<std::string, std::string>& wrap,
                                     const std::string& swizzle) {
    auto node = std::make_shared<ShadeNode>();
    node->op = static_cast<Op>(place_of(op_names, op, "op"));
    if (inputs.size() > node->inputs.size() || constants.size() > node->constants.size())
        throw py::value_error("a node has at most 4 inputs and constants");
    std::copy(inputs.begin(), inputs.end(), node->inputs.begin());
    for (std::size_t i = 0; i < constants.size(); ++i) node->constants[i] = constant(constants[i]);
    node->primvar = primvar;
    node->texture = std::move(texture);
    static constexpr std::array wraps{"black", "clamp", "repeat", "mirror"};
    node->wrap_s = static_cast<Wrap>(place_of(wraps, wrap.first, "wrap"));
    node->wrap_t = static_cast<Wrap>(place_of(wraps, wrap.second, "wrap"));
    if (swizzle.size() != 4) throw py::value_error("swizzle must name 4 components");
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t component = std::string("rgba01").find(swizzle[i]);
        if (component == std::string::npos)
            throw py::value_error("swizzle '" + swizzle + "' must consist of r, g, b, a, 0, 1");
        node->swizzle[i] = static_cast<std::uint8_t>(component);
    }
    return node;
}

// ---- materials

using Connected = std::map<std::string, std::pair<std::int32_t, std::string>>;

Material make_material(const Triple& diffuse, const Triple& emissive, const Triple& specular,
                       bool specular_workflow, bool presence, float metallic, float roughness,
                       float clearcoat, float clearcoat_roughness, float opacity,
                       float opacity_threshold, float ior, const Triple& normal,
                       const Triple& transmission,
                       const std::vector<std::shared_ptr<ShadeNode>>& nodes,
                       const Connected& connected) {
    Material material;
    material.diffuse_color = vec3f(diffuse);
    material.emissive_color = vec3f(emissive);
    material.specular_color = vec3f(specular);
    material.use_specular_workflow = specular_workflow;
    material.opacity_is_presence = presence;
    material.metallic = metallic;
    material.roughness = roughness;
    material.clearcoat = clearcoat;
    material.clearcoat_roughness = clearcoat_roughness;
    material.opacity = opacity;
    material.opacity_threshold = opacity_threshold;
    material.ior = ior;
    material.normal = vec3f(normal);
    material.transmission_color = vec3f(transmission);
    for (const std::shared_ptr<ShadeNode>& node : nodes) material.nodes.push_back(*node);
    static constexpr std::array channels{"r", "g", "b", "a", "rgb"};
    for (const auto& [name, connection] : connected)
        material.connected[place_of(surface_input_names, name, "input")] = {
            connection.first,
            static_cast<std::uint8_t>(place_of(channels, connection.second, "channel"))};
    check(material, "material");
    return material;
}

}  // namespace

void bind_materials(py::module_& module) {
    bind_texture(module);
    py::class_<ShadeNode, std::shared_ptr<ShadeNode>>(module, "ShadeNode")
        .def(py::init(&make_node), py::arg("op"), py::arg("inputs") = py::tuple(),
             py::arg("constants") = py::tuple(), py::kw_only(), py::arg("primvar") = "",
             py::arg("texture") = py::none(), py::arg("wrap") = py::make_tuple("repeat", "repeat"),
             py::arg("swizzle") = "rgba");
    const Material d;
    const auto triple = [](const V3f& v) {
        return Triple{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
    };
    py::class_<Material>(module, "Material")
        .def(py::init(&make_material), py::kw_only(),
             py::arg("diffuse_color") = triple(d.diffuse_color),
             py::arg("emissive_color") = triple(d.emissive_color),
             py::arg("specular_color") = triple(d.specular_color),
             py::arg("use_specular_workflow") = d.use_specular_workflow,
             py::arg("opacity_is_presence") = d.opacity_is_presence,
             py::arg("metallic") = d.metallic, py::arg("roughness") = d.roughness,
             py::arg("clearcoat") = d.clearcoat,
             py::arg("clearcoat_roughness") = d.clearcoat_roughness, py::arg("opacity") = d.opacity,
             py::arg("opacity_threshold") = d.opacity_threshold, py::arg("ior") = d.ior,
             py::arg("normal") = triple(d.normal),
             py::arg("transmission_color") = triple(d.transmission_color),
             py::arg("nodes") = py::tuple(), py::arg("connected") = py::dict());
    module.attr("SHADE_OPS") = py::cast(std::vector<std::string>(op_names.begin(), op_names.end()));
}

}  // namespace irt::bindings
