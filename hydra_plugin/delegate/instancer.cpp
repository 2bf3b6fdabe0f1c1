// SPDX-License-Identifier: Apache-2.0
#include "delegate/instancer.h"

#include <cmath>

#include "delegate/convert.h"
#include "delegate/renderParam.h"
#include "pxr/base/gf/quath.h"
#include "pxr/base/gf/vec4f.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

template <class T>
VtArray<T> ArrayOf(HdSceneDelegate& delegate, const SdfPath& id, const TfToken& name) {
    const VtValue value = delegate.Get(id, name);
    if (value.IsEmpty() || value.IsHolding<VtArray<T>>())
        return value.GetWithDefault<VtArray<T>>(VtArray<T>());
    TF_WARN("<%s>: its %s are of type %s, and not used", id.GetText(), name.GetText(),
            value.GetTypeName().c_str());
    return {};
}

std::vector<GfQuatd> Rotations(HdSceneDelegate& delegate, const SdfPath& id) {
    const VtValue value = delegate.Get(id, HdInstancerTokens->instanceRotations);
    std::vector<GfQuatd> out;
    if (value.IsHolding<VtQuathArray>())
        for (const GfQuath& q : value.UncheckedGet<VtQuathArray>()) out.emplace_back(q);
    else if (value.IsHolding<VtQuatfArray>())
        for (const GfQuatf& q : value.UncheckedGet<VtQuatfArray>()) out.emplace_back(q);
    else if (value.IsHolding<VtVec4fArray>())
        for (const GfVec4f& q : value.UncheckedGet<VtVec4fArray>())
            out.emplace_back(q[0], q[1], q[2], q[3]);
    else if (!value.IsEmpty())
        TF_WARN("<%s>: its rotations are of type %s, and not used", id.GetText(),
                value.GetTypeName().c_str());
    return out;
}

bool Regular(const GfMatrix4d& m) {
    for (int i = 0; i < 16; ++i)
        if (!std::isfinite(m.GetArray()[i])) return false;
    return m.GetDeterminant3() != 0;
}

}  // namespace

void HdIrtInstancer::Sync(HdSceneDelegate* delegate, HdRenderParam* param, HdDirtyBits* dirtyBits) {
    _UpdateInstancer(delegate, dirtyBits);
    const SdfPath& id = GetId();
    if (HdChangeTracker::IsAnyPrimvarDirty(*dirtyBits, id)) {
        _matrices = ArrayOf<GfMatrix4d>(*delegate, id, HdInstancerTokens->instanceTransforms);
        _translations = ArrayOf<GfVec3f>(*delegate, id, HdInstancerTokens->instanceTranslations);
        _scales = ArrayOf<GfVec3f>(*delegate, id, HdInstancerTokens->instanceScales);
        _rotations = Rotations(*delegate, id);
        _native = _translations.empty() && _scales.empty() && _rotations.empty();
    }
    HdIrtScene& scene = static_cast<HdIrtRenderParam*>(param)->scene;
    if (_native) {
        scene.RemoveInstancer(id);
    } else {
        HdIrtInstancerPlace place;
        place.world_from_array = HdIrtMatrix(delegate->GetInstancerTransform(id));
        auto* parent =
            dynamic_cast<HdIrtInstancer*>(delegate->GetRenderIndex().GetInstancer(GetParentId()));
        if (parent) {
            place.parent = HdIrtName(*delegate, GetParentId());
            place.entries = parent->Entries(id);
        }
        scene.SetInstancer(id, HdIrtName(*delegate, id), std::move(place));
    }
}

void HdIrtInstancer::Finalize(HdRenderParam* param) {
    static_cast<HdIrtRenderParam*>(param)->scene.RemoveInstancer(GetId());
}

bool HdIrtInstancer::_Place(int instance, GfMatrix4d& placed) const {
    if (instance < 0) return false;
    const auto i = static_cast<std::size_t>(instance);
    placed.SetIdentity();
    if (_native) {
        if (i >= _matrices.size()) return false;
        placed = _matrices[i];
        return true;
    }
    const auto given = [&](std::size_t size) { return size == 0 || i < size; };
    if (!given(_translations.size()) || !given(_scales.size()) || !given(_rotations.size()))
        return false;
    // As UsdGeomPointInstancer composes them, so that the same bits come out.
    if (!_scales.empty()) placed.SetScale(GfVec3d(_scales[i]));
    if (!_rotations.empty()) {
        GfMatrix4d rotation;
        rotation.SetRotate(_rotations[i]);
        placed *= rotation;
    }
    if (!_translations.empty()) placed.SetTranslateOnly(GfVec3d(_translations[i]));
    return true;
}

VtMatrix4dArray HdIrtInstancer::WorldTransforms(const SdfPath& prototype) {
    HdSceneDelegate& delegate = *GetDelegate();
    const GfMatrix4d own = delegate.GetInstancerTransform(GetId());
    VtMatrix4dArray places;
    for (const int instance : delegate.GetInstanceIndices(GetId(), prototype)) {
        GfMatrix4d placed;
        if (_Place(instance, placed))
            places.push_back(placed * own);
        else
            TF_WARN("<%s>: there is no instance %d; it is left out", GetId().GetText(), instance);
    }
    auto* parent =
        dynamic_cast<HdIrtInstancer*>(delegate.GetRenderIndex().GetInstancer(GetParentId()));
    if (!parent) return places;
    VtMatrix4dArray all;
    for (const GfMatrix4d& outer : parent->WorldTransforms(GetId()))
        for (const GfMatrix4d& inner : places) all.push_back(inner * outer);
    return all;
}

std::vector<HdIrtEntry> HdIrtInstancer::Entries(const SdfPath& prototype) {
    std::vector<HdIrtEntry> entries;
    std::size_t bad = 0;
    for (const int instance : GetDelegate()->GetInstanceIndices(GetId(), prototype)) {
        GfMatrix4d m;
        if (!_Place(instance, m) || !Regular(m)) {
            ++bad;
            continue;
        }
        entries.push_back({instance,
                           {m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1],
                            m[2][2], m[3][0], m[3][1], m[3][2]}});
    }
    if (bad != 0)
        TF_WARN(
            "<%s>: %zu instances of <%s> are left out: there is none of the index, or its "
            "transform is singular",
            GetId().GetText(), bad, prototype.GetText());
    return entries;
}

PXR_NAMESPACE_CLOSE_SCOPE
