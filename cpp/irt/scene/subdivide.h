// SPDX-License-Identifier: Apache-2.0
// Subdivision surfaces: a control cage to the polygons that stand for its limit surface, uniformly
// and by topology alone, so that both front ends and every frame give the same.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "irt/scene/records.h"

namespace irt {

enum class SubdivisionScheme : std::uint8_t { CatmullClark, Loop, Bilinear };

/// UsdGeomMesh's interpolateBoundary.
enum class BoundaryRule : std::uint8_t { None, EdgeOnly, EdgeAndCorner };

/// UsdGeomMesh's faceVaryingLinearInterpolation.
enum class FaceVaryingRule : std::uint8_t {
    None,
    CornersOnly,
    CornersPlus1,
    CornersPlus2,
    Boundaries,
    All
};

/// UsdGeomMesh's subdivision attributes, and how often faces are cut.
struct Subdivision {
    SubdivisionScheme scheme = SubdivisionScheme::CatmullClark;
    int level = 0;  ///< 0 to 8; 0: the control cage
    BoundaryRule boundary = BoundaryRule::EdgeAndCorner;
    FaceVaryingRule face_varying = FaceVaryingRule::CornersPlus1;
    bool smooth_triangles = false;  ///< triangleSubdivisionRule "smooth"
    std::vector<std::int32_t> crease_indices, crease_lengths;
    std::vector<float> crease_sharpnesses;  ///< one a crease, or one an edge
    std::vector<std::int32_t> corner_indices;
    std::vector<float> corner_sharpnesses;
    std::vector<std::int32_t> hole_indices;
    bool name_elements = false;  ///< fill Mesh::elements with the cage's faces
};

struct RefinedTopology;

/// Subdivides cages by one set of rules. The refined topology is kept, and used again while cages
/// have the topology of the one before: points and primvars alone may then differ.
class Subdivider {
  public:
    /// Throws std::invalid_argument on a level that is out of range.
    explicit Subdivider(Subdivision rules);
    ~Subdivider();
    Subdivider(Subdivider&&) noexcept;
    Subdivider& operator=(Subdivider&&) noexcept;

    /// The cage's faces cut `level` times, holes left out. Points are on the limit surface, normals
    /// are the limit surface's (on either side of what is sharp its own), and primvars follow their
    /// interpolation: vertex ones as points do, varying and uniform ones linearly and face by face,
    /// face-varying ones by the topology of their indices. The cage's own normals are not read.
    ///
    /// At level 0 the cage itself, with smooth normals: at each point the sum of the cross products
    /// of the edges of its corners, which is what usdview shows. Bilinear meshes have facets.
    ///
    /// Throws std::invalid_argument where OpenSubdiv refuses the topology, a Loop mesh has other
    /// faces than triangles, or holes name faces that are not there.
    Mesh refine(const Mesh& cage);

    /// What of the rules the last cage was refined without, and why: creases and corners whose
    /// arrays contradict each other, or that name what is not there.
    [[nodiscard]] const std::vector<std::string>& left_out() const { return left_out_; }

  private:
    [[nodiscard]] bool known(const Mesh& cage) const;

    Subdivision rules_;
    std::vector<std::string> contradictions_, left_out_;
    std::unique_ptr<RefinedTopology> topology_;  ///< null at level 0, and before the first cage
};

/// A Subdivider's work on a single cage.
Mesh subdivide(const Mesh& cage, const Subdivision& rules);

}  // namespace irt
