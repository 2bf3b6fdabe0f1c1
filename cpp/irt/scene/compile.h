// SPDX-License-Identifier: Apache-2.0
// Records made ready for tracing: done here once, for every front end alike (DESIGN 2).
#pragma once

#include <functional>
#include <string>

#include "irt/scene/scene.h"

namespace irt {

using MaterialIndex = std::function<std::uint32_t(const std::string& name)>;

/// The inverse of an affine matrix. Throws std::invalid_argument, beginning with `path`, where `m`
/// is not finite, not affine, or singular to working precision.
M44d checked_inverse(const M44d& m, const std::string& path);

/// Throws std::invalid_argument, beginning with `path` and naming the primvar, unless all are
/// constant and whole.
void check_constant(const Primvars& primvars, const std::string& path);

/// Cuts the polygons of `mesh` into triangles, positions taken to trace space in double and then
/// narrowed. Throws std::invalid_argument, beginning with `path`, on broken topology or values.
std::shared_ptr<const Triangles> triangulate(const std::shared_ptr<const Mesh>& mesh,
                                             const M44d& trace_from_shape, const std::string& path);

/// `geometry` must be a mesh or a quadric.
Surface compile_surface(const Geometry& geometry, const M44d& trace_from_shape,
                        std::uint32_t material, std::vector<std::uint32_t> face_materials,
                        const std::string& path);

/// Throws std::invalid_argument, beginning with `path`, where a face names no material.
void check_face_materials(const Surface& surface, const std::string& path);

/// The slots of `names`, in their order.
std::vector<std::uint32_t> slots_of(const std::vector<std::string>& names,
                                    const MaterialIndex& material);

/// `compile_nested` is asked for the prototypes of arrays among the parts.
std::shared_ptr<const CompiledPrototype> compile_prototype(const Prototype& prototype,
                                                           const MaterialIndex& material,
                                                           const PrototypeCompiler& compile_nested,
                                                           const std::string& path);

/// Throws std::invalid_argument, beginning with `path`, where the arrays of `array` do not fit
/// together.
void check_array(const InstanceArray& array, const std::string& path);

/// The materials that `surface` shows, added to `slots`.
void add_materials(const Surface& surface, std::vector<std::uint32_t>& slots);

/// The box of `surface` in its trace space.
trace::Box box_of(const Surface& surface);

/// Share of light a primitive of this material lets through to shadow rays: (1 - opacity) times
/// diffuse colour, as optical depth (docs/shading.md).
trace::OpticalDepth shadow_depth(const SurfaceValues& material);

}  // namespace irt
