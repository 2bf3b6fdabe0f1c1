// SPDX-License-Identifier: Apache-2.0
// What rprims of every kind have in common. A dirty bit says what to read again; whether it has
// changed is the core's to find out, record by record.
#pragma once

#include "delegate/primvars.h"
#include "delegate/scene.h"
#include "pxr/imaging/hd/rprim.h"

PXR_NAMESPACE_OPEN_SCOPE

class HdIrtShapePrim : public HdRprim {
  public:
    explicit HdIrtShapePrim(const SdfPath& id) : HdRprim(id) {}

    void Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits,
              const TfToken& repr) final;
    void Finalize(HdRenderParam* param) final;
    HdDirtyBits GetInitialDirtyBitsMask() const final;
    const TfTokenVector& GetBuiltinPrimvarNames() const final;

  protected:
    /// Reads geometry (and `face_materials`) into `shape`, with the primvars that `wanted` names;
    /// false, and warned of, where there is nothing to draw.
    virtual bool _ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                               HdIrtShape& shape) = 0;
    /// Dirty bits that _ReadGeometry answers.
    [[nodiscard]] virtual HdDirtyBits _GeometryBits() const;
    /// Of what the shape wears beside its material: names of materials, primvars and all.
    [[nodiscard]] virtual std::vector<std::string> _OtherMaterials(
        HdSceneDelegate& /*delegate*/) const {
        return {};
    }

    GfMatrix4d _turn{1};  ///< from the geometry's space to the prim's

    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const final { return bits; }
    void _InitRepr(const TfToken& repr, HdDirtyBits* dirtyBits) final;

  private:
    void _ReadPlace(HdSceneDelegate& delegate);
    void _ReadInstances(HdSceneDelegate& delegate, const GfMatrix4d& transform);

    HdIrtShape _shape;
    std::set<std::string> _wanted;  ///< primvars that geometry was read with
    bool _drawable = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
