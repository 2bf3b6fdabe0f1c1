// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "delegate/scene.h"
#include "pxr/imaging/hd/light.h"

PXR_NAMESPACE_OPEN_SCOPE

const TfTokenVector& HdIrtLightTypes();

/// A light of UsdLux, reduced to delta lights as docs/shading.md has it.
class HdIrtLightPrim final : public HdLight {
  public:
    HdIrtLightPrim(const TfToken& type, const SdfPath& id) : HdLight(id), _type(type) {}
    static bool Draws(const TfToken& type);

    void Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* param) override;
    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }

  private:
    TfToken _type;
};

PXR_NAMESPACE_CLOSE_SCOPE
