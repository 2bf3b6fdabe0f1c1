// SPDX-License-Identifier: Apache-2.0
#include "delegate/shapePrim.h"

#include <cmath>

#include "delegate/convert.h"
#include "delegate/displayColor.h"
#include "delegate/instancer.h"
#include "delegate/renderParam.h"
#include "pxr/imaging/hd/renderIndex.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Under which nothing can be drawn.
bool Broken(const GfMatrix4d& m) {
    for (int i = 0; i < 16; ++i)
        if (!std::isfinite(m.GetArray()[i])) return true;
    return m.GetDeterminant3() == 0;
}

}  // namespace

HdDirtyBits HdIrtShapePrim::GetInitialDirtyBitsMask() const {
    return HdChangeTracker::InitRepr | HdChangeTracker::AllSceneDirtyBits;
}

const TfTokenVector& HdIrtShapePrim::GetBuiltinPrimvarNames() const {
    static const TfTokenVector none;
    return none;
}

HdDirtyBits HdIrtShapePrim::_GeometryBits() const {
    return HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyTopology |
           HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyNormals |
           HdChangeTracker::DirtyWidths | HdChangeTracker::DirtySubdivTags |
           HdChangeTracker::DirtyDisplayStyle | HdChangeTracker::DirtyDoubleSided |
           HdChangeTracker::DirtyCullStyle;
}

void HdIrtShapePrim::_InitRepr(const TfToken& repr, HdDirtyBits* /*dirtyBits*/) {
    const auto known = std::find_if(_reprs.begin(), _reprs.end(), _ReprComparator(repr));
    if (known == _reprs.end()) _reprs.emplace_back(repr, HdReprSharedPtr());
}

void HdIrtShapePrim::Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits,
                          const TfToken& /*repr*/) {
    HdIrtScene& scene = static_cast<HdIrtRenderParam*>(param)->scene;
    const HdDirtyBits bits = *dirtyBits;
    const SdfPath& id = GetId();
    if (bits & HdChangeTracker::DirtyMaterialId) SetMaterialId(delegate->GetMaterialId(id));
    _UpdateVisibility(delegate, dirtyBits);
    _UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), GetInstancerId());

    _shape.material = GetMaterialId().IsEmpty() ? "" : HdIrtName(*delegate, GetMaterialId());
    _shape.visible = IsVisible();
    _shape.render_tag = GetRenderTag(delegate);
    _shape.prim_id = GetPrimId();
    if (bits & (HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyMaterialId))
        _shape.own = HdIrtDisplayMaterial(*delegate, id);
    if (bits & HdChangeTracker::DirtyCategories) {
        _shape.categories.clear();
        for (const TfToken& category : delegate->GetCategories(id))
            _shape.categories.insert(category.GetString());
    }
    std::set<std::string> wanted = scene.PrimvarsOf(_shape.material);
    for (const std::string& other : _OtherMaterials(*delegate))
        wanted.merge(scene.PrimvarsOf(other));
    if (wanted.empty() && _shape.own)
        for (const irt::ShadeNode& node : _shape.own->nodes)
            if (!node.primvar.empty()) wanted.insert(node.primvar);
    if ((bits & _GeometryBits()) != 0 || wanted != _wanted) {
        _wanted = wanted;
        _drawable = _ReadGeometry(*delegate, wanted, _shape);
    }
    _ReadPlace(*delegate);
    if (_drawable)
        scene.SetShape(id, _shape);
    else
        scene.RemoveShape(id);
    *dirtyBits &= ~HdChangeTracker::AllSceneDirtyBits;
}

void HdIrtShapePrim::Finalize(HdRenderParam* param) {
    static_cast<HdIrtRenderParam*>(param)->scene.RemoveShape(GetId());
}

void HdIrtShapePrim::_ReadPlace(HdSceneDelegate& delegate) {
    const GfMatrix4d transform = _turn * delegate.GetTransform(GetId());
    _shape.placements.clear();
    _shape.entries.clear();
    _shape.instancer.clear();
    _shape.native = false;
    if (Broken(transform)) {
        TF_WARN("<%s>: its transform holds a NaN or is singular; it is not drawn",
                GetId().GetText());
        return;
    }
    if (GetInstancerId().IsEmpty())
        _shape.placements.push_back({HdIrtName(delegate, GetId()), HdIrtMatrix(transform)});
    else
        _ReadInstances(delegate, transform);
}

void HdIrtShapePrim::_ReadInstances(HdSceneDelegate& delegate, const GfMatrix4d& transform) {
    auto* instancer =
        dynamic_cast<HdIrtInstancer*>(delegate.GetRenderIndex().GetInstancer(GetInstancerId()));
    if (!instancer) {
        TF_WARN("<%s>: its instancer <%s> is not there; it is not drawn", GetId().GetText(),
                GetInstancerId().GetText());
        return;
    }
    if (!instancer->IsNative()) {
        _shape.instancer = HdIrtName(delegate, GetInstancerId());
        _shape.prototype_from_object = HdIrtMatrix(transform);
        _shape.entries = instancer->Entries(GetId());
        return;
    }
    _shape.native = true;
    const VtMatrix4dArray places = instancer->WorldTransforms(GetId());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const GfMatrix4d world = transform * places[i];
        if (Broken(world)) continue;
        const SdfPath prim = delegate.GetScenePrimPath(GetId(), static_cast<int>(i));
        std::string name = HdIrtName(delegate, prim.IsEmpty() ? GetId() : prim);
        if (prim.IsEmpty() || prim == GetId()) name += "[" + std::to_string(i) + "]";
        _shape.placements.push_back({std::move(name), HdIrtMatrix(world)});
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
