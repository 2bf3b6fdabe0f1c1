// SPDX-License-Identifier: Apache-2.0
#include "irt/scene/compile.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "irt/math/libm.h"
#include "irt/scene/placement.h"
#include "irt/scene/polygon.h"
#include "irt/trace/judge_many.h"

namespace irt {

namespace {

/// Condition beyond which an inverse has no correct digit left in the float positions it serves.
constexpr double max_condition = 1e14;

/// Least determinant, as a share of the product of the rows' or the columns' lengths (Hadamard's
/// bound), at which an inverse is good to 1e-7: what a judge then accepts lies within the boxes
/// that Embree is handed. A matrix of rank 1 passes the condition above: its cofactors are rounding
/// noise.
constexpr double min_independence = 1e-9;

/// Products and inverses of affine matrices, as exporters write them, leave their last column by a
/// few ulp; it is not read.
constexpr double affine_tolerance = 1e-9;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
    throw std::invalid_argument(path + ": " + what);
}

double largest_entry(const M44d& m) {
    double largest = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) largest = std::max(largest, std::fabs(m[i][j]));
    return largest;
}

std::size_t elements(const Mesh& mesh, Interpolation interpolation) {
    switch (interpolation) {
        case Interpolation::None:
            return 0;
        case Interpolation::Constant:
            return 1;
        case Interpolation::Uniform:
            return mesh.face_vertex_counts.size();
        case Interpolation::Varying:
        case Interpolation::Vertex:
            return mesh.points.size();
        case Interpolation::FaceVarying:
            return mesh.face_vertex_indices.size();
    }
    return 0;
}

void check(const Primvar& primvar, std::size_t expected, const std::string& path) {
    const std::string name = "primvar " + primvar.name;
    if (primvar.interpolation == Interpolation::None) refuse(path, name + " has no interpolation");
    if (primvar.width < 1 || primvar.width > 4)
        refuse(path, name + " has values of " + std::to_string(primvar.width) +
                         " floats, expected 1 to 4");
    const auto width = static_cast<std::size_t>(primvar.width);
    if (primvar.values.size() % width != 0)
        refuse(path, name + " ends within a value of " + std::to_string(width) + " floats");
    const std::size_t count = primvar.values.size() / width;
    const bool indexed = !primvar.indices.empty();
    if ((indexed ? primvar.indices.size() : count) != expected)
        refuse(path, name + " has " + std::to_string(indexed ? primvar.indices.size() : count) +
                         " elements, expected " + std::to_string(expected));
    for (const std::int32_t index : primvar.indices)
        if (index < 0 || static_cast<std::size_t>(index) >= count)
            refuse(path, name + " has index " + std::to_string(index) + ", but " +
                             std::to_string(count) + " values");
    if (!std::all_of(primvar.values.begin(), primvar.values.end(),
                     [](float x) { return std::isfinite(x); }))
        refuse(path, name + " has a NaN or infinite entry");
}

void check_names(const Primvars& primvars, const std::string& path) {
    for (std::size_t i = 1; i < primvars.size(); ++i)
        if (primvars[i - 1].name >= primvars[i].name)
            refuse(path, "primvars are not sorted by name, each once");
}

void check(const Mesh& mesh, const std::string& path) {
    std::size_t corners = 0;
    for (const std::int32_t count : mesh.face_vertex_counts) {
        if (count < 0) refuse(path, "faceVertexCounts has a negative entry");
        corners += static_cast<std::size_t>(count);
    }
    if (corners != mesh.face_vertex_indices.size())
        refuse(path, "sum of faceVertexCounts " + std::to_string(corners) +
                         " is not the size of faceVertexIndices " +
                         std::to_string(mesh.face_vertex_indices.size()));
    for (const std::int32_t index : mesh.face_vertex_indices)
        if (index < 0 || static_cast<std::size_t>(index) >= mesh.points.size())
            refuse(path, "faceVertexIndices names point " + std::to_string(index) + " of " +
                             std::to_string(mesh.points.size()));
    const std::size_t normals = elements(mesh, mesh.normals_interpolation);
    if (mesh.normals.size() != normals)
        refuse(path, "normals has " + std::to_string(mesh.normals.size()) + " entries, expected " +
                         std::to_string(normals));
    if (!mesh.face_materials.empty() &&
        mesh.face_materials.size() != mesh.face_vertex_counts.size())
        refuse(path, "face_materials has " + std::to_string(mesh.face_materials.size()) +
                         " entries, expected " + std::to_string(mesh.face_vertex_counts.size()));
    if (!mesh.elements.empty() && mesh.elements.size() != mesh.face_vertex_counts.size())
        refuse(path, "elements has " + std::to_string(mesh.elements.size()) +
                         " entries, expected " + std::to_string(mesh.face_vertex_counts.size()));
    check_names(mesh.primvars, path);
    for (const Primvar& primvar : mesh.primvars)
        check(primvar, elements(mesh, primvar.interpolation), path);
    const auto finite = [](const V3f& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    if (!std::all_of(mesh.points.begin(), mesh.points.end(), finite))
        refuse(path, "points has a NaN or infinite entry");
    if (!std::all_of(mesh.normals.begin(), mesh.normals.end(), finite))
        refuse(path, "normals has a NaN or infinite entry");
}

void check(const Quadric& q, const std::string& path) {
    const bool two_radii = q.kind == QuadricKind::Frustum || q.kind == QuadricKind::RoundCone;
    const double radius = two_radii ? std::max(q.radius, q.radius_top) : q.radius;
    for (const double length : {radius, q.height, q.size, q.width, q.length})
        if (!(length > 0) || !std::isfinite(length))
            refuse(path, "radius, height, size, width and length must be positive and finite");
    if (two_radii && !(q.radius >= 0 && q.radius_top >= 0))
        refuse(path, "the radii must not be negative");
}

/// Primvars of points or curves: so many uniform elements, so many by ball.
void check(const Primvars& primvars, std::size_t uniform, std::size_t balls,
           const std::string& path) {
    check_names(primvars, path);
    for (const Primvar& primvar : primvars) {
        if (primvar.interpolation == Interpolation::FaceVarying)
            refuse(path, "primvar " + primvar.name + " must be constant, uniform or by vertex");
        check(primvar,
              primvar.interpolation == Interpolation::Uniform  ? uniform
              : primvar.interpolation == Interpolation::Vertex ? balls
                                                               : 1,
              path);
    }
}

/// `balls` in trace space must be within the range of single precision, which Embree's boxes have.
void check(const std::vector<Ball>& balls, const M44d& trace_from_shape, const std::string& path) {
    constexpr double most = std::numeric_limits<float>::max();
    const double gain = 3 * largest_entry(trace_from_shape);
    for (const Ball& ball : balls) {
        const V3d p = transform_point(trace_from_shape, V3d(ball.centre));
        const auto radius = static_cast<double>(ball.radius);
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            refuse(path, "points has a NaN or infinite entry");
        if (!(radius >= 0) || !std::isfinite(radius))
            refuse(path, "widths must be finite and not negative");
        const double reach =
            std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}) + gain * radius;
        if (!(reach < most / 2))
            refuse(path, "points leave the range of single precision under the transform");
    }
}

}  // namespace

void check_constant(const Primvars& primvars, const std::string& path) {
    check_names(primvars, path);
    for (const Primvar& primvar : primvars) {
        if (primvar.interpolation != Interpolation::Constant)
            refuse(path, "primvar " + primvar.name + " of an object must be constant");
        check(primvar, 1, path);
    }
}

M44d checked_inverse(const M44d& m, const std::string& path) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            if (!std::isfinite(m[i][j])) refuse(path, "transform has a NaN or infinite entry");
    if (std::max({std::fabs(m[0][3]), std::fabs(m[1][3]), std::fabs(m[2][3]),
                  std::fabs(m[3][3] - 1)}) > affine_tolerance)
        refuse(path, "transform is not affine (its last column must be 0 0 0 1)");
    const Adjugate adjugate = adjugate_of(m);
    const double determinant = adjugate.determinant;
    double largest_cofactor = 0;
    for (const auto& row : adjugate.entries)
        for (const double entry : row)
            largest_cofactor = std::max(largest_cofactor, std::fabs(entry));
    double rows = 1, columns = 1;
    for (int i = 0; i < 3; ++i) {
        rows *= V3d(m[i][0], m[i][1], m[i][2]).length();
        columns *= V3d(m[0][i], m[1][i], m[2][i]).length();
    }
    if (determinant == 0 || !std::isfinite(determinant) ||
        std::fabs(determinant) < min_independence * std::min(rows, columns) ||
        largest_entry(m) * largest_cofactor > max_condition * std::fabs(determinant))
        refuse(path, "transform is singular");
    return inverse_of(m);
}

std::shared_ptr<const Triangles> triangulate(const std::shared_ptr<const Mesh>& mesh,
                                             const M44d& trace_from_shape,
                                             const std::string& path) {
    check(*mesh, path);
    auto out = std::make_shared<Triangles>();
    out->mesh = mesh;
    out->points.reserve(mesh->points.size());
    for (const V3f& p : mesh->points)
        out->points.emplace_back(V3f(transform_point(trace_from_shape, V3d(p))));
    for (const V3f& p : out->points)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            refuse(path, "points leave the range of single precision under the transform");

    // The authored front stays the front: a mirroring transform reverses the winding it is seen by.
    const V3d x{trace_from_shape[0][0], trace_from_shape[0][1], trace_from_shape[0][2]};
    const V3d y{trace_from_shape[1][0], trace_from_shape[1][1], trace_from_shape[1][2]};
    const V3d z{trace_from_shape[2][0], trace_from_shape[2][1], trace_from_shape[2][2]};
    const bool reverse = mesh->left_handed != (x.cross(y).dot(z) < 0);

    std::uint32_t first = 0;
    for (std::uint32_t face = 0; face < mesh->face_vertex_counts.size(); ++face) {
        const auto count = static_cast<std::uint32_t>(mesh->face_vertex_counts[face]);
        for (std::array<std::uint32_t, 3> corners : triangulate_polygon(*mesh, first, count)) {
            if (reverse) std::swap(corners[1], corners[2]);
            std::array<std::uint32_t, 3> vertices{};
            for (std::size_t c = 0; c < 3; ++c)
                vertices[c] = static_cast<std::uint32_t>(mesh->face_vertex_indices[corners[c]]);
            out->triangles.push_back(vertices);
            out->corners.push_back(corners);
            out->faces.push_back(face);
        }
        first += count;
    }
    return out;
}

void check_face_materials(const Surface& surface, const std::string& path) {
    if (!surface.triangles) return;
    const auto count = static_cast<std::int32_t>(surface.face_materials.size());
    for (const std::int32_t face : surface.triangles->mesh->face_materials)
        if (face < -1 || face >= count)
            refuse(path, "face_materials names material " + std::to_string(face) + " of " +
                             std::to_string(count));
}

std::vector<std::uint32_t> slots_of(const std::vector<std::string>& names,
                                    const MaterialIndex& material) {
    std::vector<std::uint32_t> slots;
    for (const std::string& name : names) slots.push_back(material(name));
    return slots;
}

Surface compile_surface(const Geometry& geometry, const M44d& trace_from_shape,
                        std::uint32_t material, std::vector<std::uint32_t> face_materials,
                        const std::string& path) {
    Surface surface;
    surface.trace_from_shape = trace_from_shape;
    surface.shape_from_trace = checked_inverse(trace_from_shape, path);
    surface.material = material;
    if (const auto* quadric = std::get_if<Quadric>(&geometry)) {
        check(*quadric, path);
        surface.quadric = *quadric;
    } else if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&geometry)) {
        surface.triangles = triangulate(*mesh, trace_from_shape, path);
        surface.face_materials = std::move(face_materials);
        check_face_materials(surface, path);
    } else if (const auto* spheres = std::get_if<std::shared_ptr<const Spheres>>(&geometry)) {
        check((*spheres)->balls, trace_from_shape, path);
        check((*spheres)->primvars, 1, (*spheres)->balls.size(), path);
        surface.spheres = *spheres;
    } else if (const auto* curves = std::get_if<std::shared_ptr<const Curves>>(&geometry)) {
        check((*curves)->balls, trace_from_shape, path);
        check((*curves)->primvars, (*curves)->firsts.size() - 1, (*curves)->balls.size(), path);
        surface.curves = *curves;
    } else {
        refuse(path, "a prototype's parts must not be prototypes");
    }
    return surface;
}

void check_array(const InstanceArray& array, const std::string& path) {
    const std::size_t count = array.size();
    if (array.prototypes.empty() && count > 0) refuse(path, "instances, but no prototypes");
    if (!array.prototype_of.empty() && array.prototype_of.size() != count)
        refuse(path, "prototype_of has " + std::to_string(array.prototype_of.size()) +
                         " entries, expected " + std::to_string(count));
    for (const std::uint32_t prototype : array.prototype_of)
        if (prototype >= array.prototypes.size())
            refuse(path, "prototype_of names prototype " + std::to_string(prototype) + " of " +
                             std::to_string(array.prototypes.size()));
    if (!array.keys.empty() && array.keys.size() != count)
        refuse(path, "keys has " + std::to_string(array.keys.size()) + " entries, expected " +
                         std::to_string(count));
    if (std::adjacent_find(array.keys.begin(), array.keys.end(), std::greater_equal<>()) !=
        array.keys.end())
        refuse(path, "keys must increase from entry to entry");
    constexpr std::int64_t most = std::int64_t{1} << 62;
    if (!array.keys.empty() && (array.keys.front() < -most || array.keys.back() > most))
        refuse(path, "keys must lie within 2^62 of 0");
    check_names(array.primvars, path);
    for (const Primvar& primvar : array.primvars) {
        const bool constant = primvar.interpolation == Interpolation::Constant;
        if (!constant && primvar.interpolation != Interpolation::Vertex)
            refuse(path, "primvar " + primvar.name + " must be constant or by entry");
        check(primvar, constant ? 1 : count, path);
    }
}

void add_materials(const Surface& surface, std::vector<std::uint32_t>& slots) {
    slots.push_back(surface.material);
    slots.insert(slots.end(), surface.face_materials.begin(), surface.face_materials.end());
}

trace::Box box_of(const Surface& surface) {
    trace::Box box;
    if (surface.triangles) {
        for (const auto& triangle : surface.triangles->triangles)
            for (const std::uint32_t vertex : triangle)
                box.extend(V3d(surface.triangles->points[vertex]));
        return box;
    }
    for (std::uint32_t k = 0; k < trace::primitive_count(surface); ++k)
        if (const trace::Box own = trace::primitive_box(surface, k); !own.empty()) box.extend(own);
    return box;
}

namespace {

NestedArray compile_nested_array(const std::shared_ptr<const InstanceArray>& record,
                                 const M44d& outer_from_array,
                                 const PrototypeCompiler& compile_nested, const std::string& path) {
    check_array(*record, path);
    NestedArray out;
    out.record = record;
    out.outer_from_array = outer_from_array;
    for (const auto& prototype : record->prototypes) {
        out.prototypes.push_back(compile_nested(prototype, path));
        out.stride = std::max(out.stride, out.prototypes.back()->parts);
    }
    for (std::size_t entry = 0; entry < record->size(); ++entry)
        (void)checked_inverse(out.outer_from_prototype(entry),
                              path + "[" + std::to_string(record->key(entry)) + "]");
    return out;
}

}  // namespace

std::shared_ptr<const CompiledPrototype> compile_prototype(const Prototype& prototype,
                                                           const MaterialIndex& material,
                                                           const PrototypeCompiler& compile_nested,
                                                           const std::string& path) {
    auto out = std::make_shared<CompiledPrototype>();
    std::vector<std::uint32_t>& materials = out->materials;
    for (const Part& part : prototype.parts) {
        const std::string part_path = path + "/" + part.name;
        check_constant(part.primvars, part_path);
        out->mattes = out->mattes || part.role.matte;
        if (const auto* array = std::get_if<std::shared_ptr<const InstanceArray>>(&part.geometry)) {
            if ((*array)->size() == 0) continue;
            out->arrays.push_back(
                compile_nested_array(*array, part.prototype_from_part, compile_nested, part_path));
            out->arrays.back().role = part.role;
            continue;
        }
        out->surfaces.push_back(
            compile_surface(part.geometry, part.prototype_from_part, material(part.material),
                            slots_of(part.face_materials, material), part_path));
        out->surfaces.back().primvars = part.primvars;
        out->surfaces.back().role = part.role;
        const trace::Box box = box_of(out->surfaces.back());
        if (!box.empty()) out->box.extend(box);
        add_materials(out->surfaces.back(), materials);
    }
    std::uint64_t parts = out->surfaces.size();
    for (NestedArray& array : out->arrays) {
        array.first_part = static_cast<std::uint32_t>(parts);
        parts += std::uint64_t{array.stride} * array.record->size();
        if (parts >= trace::none)
            refuse(path, "instances of instances number more than 32 bits can; nest fewer");
        for (std::size_t entry = 0; entry < array.record->size(); ++entry) {
            const trace::Box& box = array.prototype(entry).box;
            if (!box.empty()) out->box.extend(transformed(box, array.outer_from_prototype(entry)));
        }
        for (const auto& nested : array.prototypes) {
            materials.insert(materials.end(), nested->materials.begin(), nested->materials.end());
            out->mattes = out->mattes || nested->mattes;
        }
    }
    out->parts = static_cast<std::uint32_t>(parts);
    std::sort(materials.begin(), materials.end());
    materials.erase(std::unique(materials.begin(), materials.end()), materials.end());
    return out;
}

trace::OpticalDepth shadow_depth(const SurfaceValues& material) {
    const double through = 1.0 - effective_opacity(material);
    trace::OpticalDepth depth;
    for (int c = 0; c < 3; ++c) {
        // What is absent tints nothing.
        const double tint =
            is_presence(material) ? 1.0 : std::clamp(material.diffuse_color[c], 0.0, 1.0);
        const double steps = std::round(-trace::depth_scale * libm::log2(through * tint));
        depth.rgb[c] =
            steps < trace::depth_opaque ? static_cast<std::uint32_t>(steps) : trace::depth_opaque;
    }
    return depth;
}

}  // namespace irt
