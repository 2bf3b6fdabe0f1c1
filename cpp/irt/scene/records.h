// SPDX-License-Identifier: Apache-2.0
// What is rendered, as plain records. Front ends (the Python reader, the Hydra delegate) fill these
// and hand them over in a ChangeSet; the core knows nothing of USD.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "irt/math/vec.h"
#include "irt/scene/material.h"

namespace irt {

/// A quadric (or another exact convex solid of UsdGeom) in its own space, its axis along z.
enum class QuadricKind : std::uint8_t {
    Sphere,
    Cube,
    Cylinder,
    Cone,
    Capsule,
    Plane,
    Frustum,
    RoundCone
};

/// Lengths are in object units; the kinds use: Sphere radius; Cube size; Cylinder, Cone and Capsule
/// radius and height (of the capsule: without its caps); Plane width (x) and length (y); Frustum (a
/// cylinder whose ends differ) and RoundCone (a capsule whose ends differ: the convex hull of its
/// two balls) radius at z = -height/2, radius_top at z = +height/2, and height. All solids are
/// centred on the origin; a cone's apex is at z = +height/2.
struct Quadric {
    QuadricKind kind = QuadricKind::Sphere;
    double radius = 1, height = 2, size = 2, width = 2, length = 2, radius_top = 1;
};

/// Varying differs from Vertex in subdivision alone: it is then interpolated linearly.
enum class Interpolation : std::uint8_t { None, Constant, Uniform, Varying, Vertex, FaceVarying };

/// A value given along with a shape (UsdGeomPrimvar): elements of `width` floats, as many as
/// `interpolation` asks for.
struct Primvar {
    std::string name;                                       ///< without "primvars:"
    Interpolation interpolation = Interpolation::Constant;  ///< never None
    int width = 1;                                          ///< 1 to 4
    std::vector<float> values;                              ///< `width` floats a value
    std::vector<std::int32_t> indices;  ///< the value of each element; empty: element i is value i
};

/// Sorted by name, each name once.
using Primvars = std::vector<Primvar>;

/// A polygon mesh as authored (object space). `normals` has one entry per whatever
/// `normals_interpolation` says; None means facets.
struct Mesh {
    std::vector<V3f> points;
    std::vector<std::int32_t> face_vertex_counts;
    std::vector<std::int32_t> face_vertex_indices;
    std::vector<V3f> normals;
    Interpolation normals_interpolation = Interpolation::None;
    bool left_handed = false;
    bool single_sided = false;  ///< authored doubleSided = false: back faces do not exist
    Primvars primvars = {};
    /// One a face: -1, the material of the object, or an index into its `face_materials`. Empty:
    /// all -1.
    std::vector<std::int32_t> face_materials;
    /// One a face: the number of the authored face (of ribbons: curve) that it is, or is a piece
    /// of. Empty: faces are the authored ones.
    std::vector<std::int32_t> elements = {};
};

/// A ball, lengths in object units. One of radius 0 is not there.
struct Ball {
    V3f centre;
    float radius;
};

/// Points drawn as balls (UsdGeomPoints); ball i is primitive i.
struct Spheres {
    std::vector<Ball> balls;
    Primvars primvars = {};  ///< Constant, Uniform (one value) or Vertex (a ball)
};

/// Curves as chains of round cones, the convex hulls of two neighbouring balls. Segment k, which is
/// primitive k, leads from ball k to the next of its curve; the last ball of an open curve begins
/// none. Made by make_curves (scene/curves.h).
struct Curves {
    std::vector<Ball> balls;              ///< curve after curve
    std::vector<std::uint32_t> firsts;    ///< of each curve its first ball; then the ball count
    std::vector<std::uint32_t> curve_of;  ///< by ball
    Primvars primvars = {};               ///< Constant, Uniform (a curve) or Vertex (a ball)
    bool closed = false;  ///< a segment leads from each curve's last ball to its first

    static constexpr std::uint32_t none = 0xffffffffu;
    /// The ball that segment `k` leads to; `none` where there is no such segment.
    [[nodiscard]] std::uint32_t next_ball(std::uint32_t k) const {
        const std::uint32_t curve = curve_of[k];
        if (k + 1 < firsts[curve + 1]) return k + 1;
        return closed ? firsts[curve] : none;
    }
    /// The segment that begins where segment `k` ends, or `none`.
    [[nodiscard]] std::uint32_t next_segment(std::uint32_t k) const {
        const std::uint32_t ball = next_ball(k);
        return ball == none || next_ball(ball) == none ? none : ball;
    }
    /// The segment that ends where segment `k` begins, or `none`.
    [[nodiscard]] std::uint32_t previous_segment(std::uint32_t k) const {
        const std::uint32_t curve = curve_of[k];
        if (k > firsts[curve]) return k - 1;
        return closed ? firsts[curve + 1] - 1 : none;
    }
};

struct Prototype;
struct InstanceArray;

/// What a render pass makes of an object (UsdRenderPass).
struct PassRole {
    bool camera_visible = true;  ///< false: camera rays pass it, all others meet it
    bool matte =
        false;  ///< seen by the camera it is black and transparent, and hides what is behind
    bool operator==(const PassRole&) const = default;
};

using Geometry = std::variant<Quadric, std::shared_ptr<const Mesh>,
                              std::shared_ptr<const Prototype>, std::shared_ptr<const Spheres>,
                              std::shared_ptr<const Curves>, std::shared_ptr<const InstanceArray>>;

/// One part of a prototype: geometry (or an array of instances, but no prototype by itself) placed
/// in the prototype's space.
struct Part {
    std::string name;
    Geometry geometry;
    M44d prototype_from_part;
    std::string material;    ///< unused for an array: its prototypes' parts name their own
    Primvars primvars = {};  ///< constant ones, as of an object
    std::vector<std::string> face_materials = {};  ///< see Object
    PassRole role = {};                            ///< beside that of the object
};

/// Geometry shared by instances.
struct Prototype {
    std::vector<Part> parts;
};

/// The first three columns of an affine matrix, row by row; the last is 0 0 0 1.
using Affine = std::array<double, 12>;

/// Instances in large numbers (UsdGeomPointInstancer). As an object, every entry is an object of
/// its own, named by the array's path and the entry's key; nothing is kept of an entry but what is
/// here and 8 bytes.
struct InstanceArray {
    std::vector<std::shared_ptr<const Prototype>> prototypes;
    std::vector<std::uint32_t> prototype_of;  ///< by entry: into `prototypes`; empty: all the first
    std::vector<std::int64_t> keys;           ///< by entry, increasing; empty: 0, 1, 2, ...
    std::vector<Affine> array_from_prototype;  ///< by entry
    /// Constant or Vertex (an entry): read where an entry's parts have none of the name, and where
    /// arrays nest, no inner array has.
    Primvars primvars = {};

    [[nodiscard]] std::size_t size() const { return array_from_prototype.size(); }
    [[nodiscard]] std::int64_t key(std::size_t entry) const {
        return keys.empty() ? static_cast<std::int64_t>(entry) : keys[entry];
    }
    [[nodiscard]] std::uint32_t prototype(std::size_t entry) const {
        return prototype_of.empty() ? 0 : prototype_of[entry];
    }
};

/// An object of the scene. Its name is its prim path (DESIGN 3, rule 2).
struct Object {
    Geometry geometry;
    M44d world_from_object;
    std::string material;    ///< unused for instances: their prototypes' parts name their own
    Primvars primvars = {};  ///< constant ones, read where the geometry has none of the name
    std::vector<std::string> face_materials = {};  ///< what Mesh::face_materials numbers
    PassRole role = {};
};

/// A photometric web: `values` by horizontal angle, then vertical angle (IES LM-63), as multiples
/// of the light's energy. Vertical angles are from the light's axis, horizontal ones about it, in
/// degrees, ascending.
struct IesWeb {
    std::vector<float> vertical, horizontal, values;
};

/// What a delta light that stands for an area light sends where: the area light's far field. A
/// sphere's is uniform; a rectangle's or disk's falls with the cosine to its axis and is one-sided;
/// a cylinder's falls with the sine to its length, `side`; a mesh's is that of its `facets`,
/// each seen from its own place.
enum class Profile : std::uint8_t { Uniform, Facing, Round, Facets };

/// A part of a mesh that is a light, as a small disk: its area along its outward normal, and where
/// it is from the light's position; world orientation.
struct Facet {
    V3f area, offset;
};

/// A lat-long picture around the scene, as OpenEXR's environment maps have it: the pole, y, at the
/// top; z in the middle, x a quarter of the width to its left.
struct Sky {
    std::shared_ptr<const Texture> texture;  ///< never null
    V3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};  ///< its axes in world space, orthonormal
};

/// A delta light. `energy` is irradiance at normal incidence for a distant light and the greatest
/// radiant intensity for a point light, in scene-linear RGB. An environment light lights no
/// surface: it is what rays see that meet nothing, `energy` being its radiance, times what `sky`
/// shows there.
enum class LightKind : std::uint8_t { Distant, Point, Environment };
struct Light {
    LightKind kind = LightKind::Distant;
    V3d direction{0, 0, -1};  ///< world space, unit: the way the light travels; a point's axis
    V3d position{0, 0, 0};    ///< world space (Point)
    V3f energy{1, 1, 1};
    bool casts_shadows = true;

    Profile profile = Profile::Uniform;
    V3d side{1, 0, 0};  ///< world space, unit, across `direction`
    float diffuse = 1, specular = 1;
    float cone_angle = 180, cone_softness = 0;  ///< degrees from the axis; a share of them
    float focus = 0;
    V3f focus_tint{0, 0, 0};
    std::shared_ptr<const IesWeb> ies;  ///< may be null
    std::shared_ptr<const Sky> sky;     ///< Environment; may be null
    std::vector<Facet> facets;          ///< of Profile::Facets
    V3f shadow_color{0, 0, 0};          ///< of shadows, as a share of the light
    /// What is farther from the lit point casts no shadow; negative: any distance.
    float shadow_distance = -1;
    /// Where that is not negative: how far from it shadows begin to fade, and the exponent of that.
    float shadow_falloff = 0, shadow_falloff_gamma = 1;
    /// Paths of the objects that it does not light, ascending.
    std::vector<std::string> unlit;
    /// Paths of the objects that cast none of its shadows, ascending.
    std::vector<std::string> shadowless;
    bool camera_visible =
        true;  ///< false: camera rays that meet nothing do not see it (Environment)
};

/// A camera. Camera space looks along -z, y up. `window` is (left, right, bottom, top) of the image
/// on the plane z = -1 (perspective) or in camera units (orthographic). Primary rays see what lies
/// between the depths `near` (at least 0) and `far`, along -z in camera units.
struct Camera {
    M44d world_from_camera;
    bool orthographic = false;
    std::array<double, 4> window{-1, 1, -1, 1};
    double near = 0, far = std::numeric_limits<double>::infinity();
};

}  // namespace irt
