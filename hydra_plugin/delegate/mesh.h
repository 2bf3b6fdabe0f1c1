// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "delegate/shapePrim.h"
#include "irt/scene/subdivide.h"
#include "pxr/imaging/hd/meshTopology.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Polygons, or a subdivision surface as the core's own polygons of it, by the refine level.
class HdIrtMesh final : public HdIrtShapePrim {
  public:
    explicit HdIrtMesh(const SdfPath& id) : HdIrtShapePrim(id) {}

  private:
    bool _ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                       HdIrtShape& shape) override;
    std::vector<std::string> _OtherMaterials(HdSceneDelegate& delegate) const override;

    [[nodiscard]] std::string _Fault(const HdMeshTopology& topology, std::size_t points) const;
    void _ReadFaceMaterials(HdSceneDelegate& delegate, const HdMeshTopology& topology,
                            irt::Mesh& mesh, HdIrtShape& shape) const;
    void _ReadNormals(HdSceneDelegate& delegate, irt::Mesh& mesh) const;
    [[nodiscard]] irt::Mesh _Refined(const irt::Mesh& cage, const HdMeshTopology& topology,
                                     int level);

    /// Rules of the last refinement, and what it found out of the topology.
    std::optional<irt::Subdivider> _subdivider;
    HdMeshTopology _topology;
    int _level = -1;
};

PXR_NAMESPACE_CLOSE_SCOPE
