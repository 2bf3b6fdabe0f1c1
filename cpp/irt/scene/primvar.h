// SPDX-License-Identifier: Apache-2.0
// Primvars looked up at hits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "irt/scene/scene.h"

namespace irt {

/// Components beyond a primvar's width are 0.
using PrimvarValue = std::array<double, 4>;

/// The one called `name`, or null.
const Primvar* find_primvar(const Primvars& primvars, std::string_view name);

/// The value of a constant primvar.
PrimvarValue constant_value(const Primvar& primvar);

/// The values of a primvar of triangles.mesh at the corners of `triangle`, in the order of
/// Triangles::triangles.
std::array<PrimvarValue, 3> corner_values(const Triangles& triangles, const Primvar& primvar,
                                          std::uint32_t triangle);

/// The value at a hit: `u` and `v` weigh the second and the third corner. Exact where all three
/// corners agree.
PrimvarValue primvar_at(const Triangles& triangles, const Primvar& primvar, std::uint32_t triangle,
                        double u, double v);

/// The values at a ball, and at `u` of the way along a segment.
PrimvarValue primvar_at(const Spheres& spheres, const Primvar& primvar, std::uint32_t ball);
PrimvarValue primvar_at(const Curves& curves, const Primvar& primvar, std::uint32_t segment,
                        double u);

/// What the arrays that the instance hit is in give by that name, the innermost that does.
struct InstancePrimvar {
    int width;
    PrimvarValue value;
};
std::optional<InstancePrimvar> instance_primvar(const Scene& scene, const trace::Hit& hit,
                                                std::string_view name);

}  // namespace irt
