// SPDX-License-Identifier: Apache-2.0
// Materials: UsdPreviewSurface's inputs, each a constant or the output of a small graph of nodes
// that belongs to the material (docs/shading.md).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "irt/math/vec.h"
#include "irt/texture/texture.h"

namespace irt {

/// What a node computes. Values have four components; operations work on each by itself but for
/// Dot, Length, Normalize, Cross, the colour models, Swizzle, Combine (graph/operations.h), noises
/// and those from Position to NormalToObject, which read where the point lies.
enum class Op : std::uint8_t {
    Constant,
    Primvar,
    Texture,
    Transform2d,
    Add,
    Subtract,
    Multiply,
    Divide,
    Min,
    Max,
    Power,
    Modulo,
    Clamp,
    Mix,
    Smoothstep,
    Absolute,
    Sign,
    Floor,
    Ceil,
    Round,
    Sqrt,
    Sin,
    Cos,
    Exp,
    Log,
    Dot,
    Length,
    Normalize,
    Cross,
    IfGreater,
    IfEqual,
    Swizzle,
    Combine,
    RgbToHsv,
    HsvToRgb,
    Acos,
    Asin,
    Atan2,
    Position,
    Normal,
    View,
    PointToWorld,
    VectorToWorld,
    NormalToWorld,
    PointToObject,
    VectorToObject,
    NormalToObject,
    Perlin2,
    Perlin3,
    PerlinVector2,
    PerlinVector3,
    Cells2,
    Cells3,
    Worley2,
    Worley3,
    WorleyCells2,
    WorleyCells3,
};
// clang-format off
inline constexpr std::array op_names{
    "constant", "primvar", "texture", "transform2d", "add", "subtract", "multiply", "divide", "min",
    "max", "power", "modulo", "clamp", "mix", "smoothstep", "absolute", "sign", "floor", "ceil",
    "round", "sqrt", "sin", "cos", "exp", "log", "dot", "length", "normalize", "cross",
    "if_greater", "if_equal", "swizzle", "combine", "rgb_to_hsv", "hsv_to_rgb", "acos", "asin",
    "atan2", "position", "normal", "view", "point_to_world", "vector_to_world", "normal_to_world",
    "point_to_object", "vector_to_object", "normal_to_object", "perlin_2d", "perlin_3d",
    "perlin_vector_2d", "perlin_vector_3d", "cells_2d", "cells_3d", "worley_2d", "worley_3d",
    "worley_cells_2d", "worley_cells_3d",
};
// clang-format on

/// The places of ShadeNode::swizzle beyond the four components.
inline constexpr std::uint8_t swizzle_zero = 4, swizzle_one = 5;

/// One node. Slots are numbered as docs/shading.md's table of operations has them.
struct ShadeNode {
    static constexpr std::int32_t unconnected = -1;

    Op op = Op::Constant;
    std::array<std::int32_t, 4> inputs{unconnected, unconnected, unconnected, unconnected};
    std::array<std::array<float, 4>, 4> constants{};  ///< of unconnected slots
    std::string primvar;                              ///< Primvar: its name
    std::shared_ptr<const Texture> texture;           ///< Texture
    Wrap wrap_s = Wrap::Repeat, wrap_t = Wrap::Repeat;
    std::array<std::uint8_t, 4> swizzle{0, 1, 2, 3};  ///< components, swizzle_zero or swizzle_one
};

/// The inputs that a graph may give.
enum class SurfaceInput : std::uint8_t {
    DiffuseColor,
    EmissiveColor,
    SpecularColor,
    Metallic,
    Roughness,
    Clearcoat,
    ClearcoatRoughness,
    Opacity,
    OpacityThreshold,
    Ior,
    Normal,
    TransmissionColor,
};
inline constexpr std::array surface_input_names{
    "diffuse_color", "emissive_color",      "specular_color", "metallic",          "roughness",
    "clearcoat",     "clearcoat_roughness", "opacity",        "opacity_threshold", "ior",
    "normal",        "transmission_color"};

/// The node that gives an input, and which of its components: all of rgb, or one.
struct Connection {
    static constexpr std::uint8_t rgb = 4;

    std::int32_t node = ShadeNode::unconnected;
    std::uint8_t channel = rgb;

    explicit operator bool() const { return node != ShadeNode::unconnected; }
};

/// Most nodes of a material: evaluation keeps their values on the stack.
inline constexpr std::size_t max_shade_nodes = 256;

/// UsdPreviewSurface's inputs, its defaults (scene-linear RGB). `occlusion` is none of them: a ray
/// tracer ignores it, as the specification says.
struct Material {
    V3f diffuse_color{0.18f, 0.18f, 0.18f};
    V3f emissive_color{0, 0, 0};
    V3f specular_color{0, 0, 0};
    bool use_specular_workflow = false;
    /// opacityMode "presence": opacity is the share of the surface that is there, not what is
    /// transmitted.
    bool opacity_is_presence = false;
    float metallic = 0;
    float roughness = 0.5f;
    float clearcoat = 0;
    float clearcoat_roughness = 0.01f;
    float opacity = 1;
    float opacity_threshold = 0;
    float ior = 1.5f;
    V3f normal{0, 0, 1};  ///< tangent space
    /// What tints a refracted ray at each surface; none of UsdPreviewSurface's, but of others.
    V3f transmission_color{1, 1, 1};

    std::vector<ShadeNode> nodes;  ///< every one after those that it reads
    std::array<Connection, surface_input_names.size()> connected{};

    [[nodiscard]] const Connection& connection(SurfaceInput input) const {
        return connected[static_cast<std::size_t>(input)];
    }
};

/// Whether a material is the same at every point.
[[nodiscard]] bool is_uniform(const Material& material);

/// Throws std::invalid_argument, beginning with `name`, on a graph that cannot be evaluated: nodes
/// that do not exist or stand behind those that read them, textures missing, too many nodes.
void check(const Material& material, const std::string& name);

/// The nodes that some of `inputs` depend on, in their order.
[[nodiscard]] std::vector<std::int32_t> nodes_behind(const Material& material,
                                                     const std::vector<SurfaceInput>& inputs);

/// Whether any of `nodes` asks where the point lies.
[[nodiscard]] bool reads_place(const Material& material, const std::vector<std::int32_t>& nodes);

/// The inputs with values, at a point or everywhere.
struct SurfaceValues {
    V3d diffuse_color, emissive_color, specular_color;
    bool use_specular_workflow, opacity_is_presence;
    double metallic, roughness, clearcoat, clearcoat_roughness, opacity, opacity_threshold, ior;
    V3d normal, transmission_color;

    SurfaceValues(const Material& material);  ///< its constants
};

/// The inputs that shadow rays read.
inline constexpr std::array tint_inputs{SurfaceInput::DiffuseColor, SurfaceInput::Opacity,
                                        SurfaceInput::OpacityThreshold};
/// Whether a material may stop one share of a shadow ray here and another there.
[[nodiscard]] bool tint_varies(const Material& material);

/// Opacity after UsdPreviewSurface's opacityThreshold: with a threshold, 0 or 1.
[[nodiscard]] double effective_opacity(const SurfaceValues& values);

/// Whether what is not opaque is not there (opacityThreshold, opacityMode "presence"), so that rays
/// go by it as they are.
[[nodiscard]] inline bool is_presence(const SurfaceValues& values) {
    return values.opacity_threshold > 0 || values.opacity_is_presence;
}

}  // namespace irt
