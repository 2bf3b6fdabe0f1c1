// SPDX-License-Identifier: Apache-2.0
#include "delegate/material.h"

#include "delegate/convert.h"
#include "delegate/network.h"
#include "delegate/renderParam.h"

PXR_NAMESPACE_OPEN_SCOPE

void HdIrtMaterial::Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits) {
    auto& irt = *static_cast<HdIrtRenderParam*>(param);
    *dirtyBits = Clean;
    const VtValue resource = delegate->GetMaterialResource(GetId());
    std::optional<irt::Material> material;
    if (resource.IsHolding<HdMaterialNetworkMap>())
        material =
            HdIrtSurface(resource.UncheckedGet<HdMaterialNetworkMap>(), GetId(), irt.textures);
    if (material)
        irt.scene.SetMaterial(GetId(), HdIrtName(*delegate, GetId()), std::move(*material));
    else
        irt.scene.RemoveMaterial(GetId());
}

void HdIrtMaterial::Finalize(HdRenderParam* param) {
    static_cast<HdIrtRenderParam*>(param)->scene.RemoveMaterial(GetId());
}

PXR_NAMESPACE_CLOSE_SCOPE
