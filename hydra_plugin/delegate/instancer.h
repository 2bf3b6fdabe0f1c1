// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "delegate/scene.h"
#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/gf/quatd.h"
#include "pxr/base/vt/array.h"
#include "pxr/imaging/hd/instancer.h"

PXR_NAMESPACE_OPEN_SCOPE

/// A native instance's or a point instancer's placements. The former's are matrices alone.
class HdIrtInstancer final : public HdInstancer {
  public:
    HdIrtInstancer(HdSceneDelegate* delegate, const SdfPath& id) : HdInstancer(delegate, id) {}

    void Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* param) override;

    /// Whether its instances are USD's own, objects under paths of theirs.
    [[nodiscard]] bool IsNative() const { return _native; }
    /// Of a native one: the world's from the space of the rprim `prototype`, by instance, those of
    /// all enclosing instancers included.
    VtMatrix4dArray WorldTransforms(const SdfPath& prototype);
    /// Of a point instancer: its entries that draw `prototype`.
    std::vector<HdIrtEntry> Entries(const SdfPath& prototype);

  private:
    [[nodiscard]] bool _Place(int instance, GfMatrix4d& placed) const;

    bool _native = true;
    VtMatrix4dArray _matrices;
    VtVec3fArray _translations, _scales;
    std::vector<GfQuatd> _rotations;
};

PXR_NAMESPACE_CLOSE_SCOPE
