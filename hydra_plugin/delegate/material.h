// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/imaging/hd/material.h"

PXR_NAMESPACE_OPEN_SCOPE

/// A material whose surface is UsdPreviewSurface.
class HdIrtMaterial final : public HdMaterial {
  public:
    explicit HdIrtMaterial(const SdfPath& id) : HdMaterial(id) {}

    void Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* param) override;
    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
};

PXR_NAMESPACE_CLOSE_SCOPE
