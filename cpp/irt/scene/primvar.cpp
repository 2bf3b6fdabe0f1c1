// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/primvar.h"

#include <algorithm>

namespace irt {

namespace {

PrimvarValue element(const Primvar& primvar, std::size_t index) {
    const auto width = static_cast<std::size_t>(primvar.width);
    const std::size_t value =
        primvar.indices.empty() ? index : static_cast<std::size_t>(primvar.indices[index]);
    PrimvarValue out{};
    for (std::size_t c = 0; c < width; ++c)
        out[c] = static_cast<double>(primvar.values[value * width + c]);
    return out;
}

}  // namespace

const Primvar* find_primvar(const Primvars& primvars, std::string_view name) {
    const auto found =
        std::lower_bound(primvars.begin(), primvars.end(), name,
                         [](const Primvar& p, std::string_view n) { return p.name < n; });
    return found != primvars.end() && found->name == name ? &*found : nullptr;
}

PrimvarValue constant_value(const Primvar& primvar) { return element(primvar, 0); }

std::array<PrimvarValue, 3> corner_values(const Triangles& triangles, const Primvar& primvar,
                                          std::uint32_t triangle) {
    std::array<PrimvarValue, 3> values{};
    const auto& corners = triangles.corners[triangle];
    for (std::size_t c = 0; c < 3; ++c) switch (primvar.interpolation) {
            case Interpolation::None:
                break;
            case Interpolation::Constant:
                values[c] = element(primvar, 0);
                break;
            case Interpolation::Uniform:
                values[c] = element(primvar, triangles.faces[triangle]);
                break;
            case Interpolation::Varying:
            case Interpolation::Vertex:
                values[c] = element(primvar, static_cast<std::size_t>(
                                                 triangles.mesh->face_vertex_indices[corners[c]]));
                break;
            case Interpolation::FaceVarying:
                values[c] = element(primvar, corners[c]);
                break;
        }
    return values;
}

PrimvarValue primvar_at(const Triangles& triangles, const Primvar& primvar, std::uint32_t triangle,
                        double u, double v) {
    const auto [a, b, c] = corner_values(triangles, primvar, triangle);
    PrimvarValue value{};
    for (std::size_t i = 0; i < value.size(); ++i)
        value[i] = a[i] + (b[i] - a[i]) * u + (c[i] - a[i]) * v;
    return value;
}

PrimvarValue primvar_at(const Spheres&, const Primvar& primvar, std::uint32_t ball) {
    return element(primvar, primvar.interpolation == Interpolation::Vertex ? ball : 0);
}

PrimvarValue primvar_at(const Curves& curves, const Primvar& primvar, std::uint32_t segment,
                        double u) {
    if (primvar.interpolation == Interpolation::Uniform)
        return element(primvar, curves.curve_of[segment]);
    if (primvar.interpolation != Interpolation::Vertex) return element(primvar, 0);
    const PrimvarValue a = element(primvar, segment),
                       b = element(primvar, curves.next_ball(segment));
    PrimvarValue value{};
    for (std::size_t i = 0; i < value.size(); ++i) value[i] = a[i] + (b[i] - a[i]) * u;
    return value;
}

std::optional<InstancePrimvar> instance_primvar(const Scene& scene, const trace::Hit& hit,
                                                std::string_view name) {
    const Primvar* found = nullptr;
    std::size_t at = 0;
    const auto look = [&](const InstanceArray& array, std::size_t entry) {
        const Primvar* const primvar = find_primvar(array.primvars, name);
        if (!primvar) return;
        found = primvar;
        at = primvar->interpolation == Interpolation::Vertex ? entry : 0;
    };
    const ObjectSlot& object = scene.object(hit.object);
    if (object.array) look(*object.array, scene.entry(hit.object));
    if (const CompiledPrototype* const prototype = scene.prototype(hit.object))
        (void)prototype->part(hit.part, [&](const NestedArray& array, std::uint32_t entry) {
            look(*array.record, entry);
        });
    if (!found) return std::nullopt;
    return InstancePrimvar{found->width, element(*found, at)};
}

}  // namespace irt
