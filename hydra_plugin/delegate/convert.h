// SPDX-License-Identifier: Apache-2.0
// OpenUSD's values as the core's.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "irt/math/vec.h"
#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/vt/array.h"
#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/usd/sdf/path.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Both multiply rows from the left.
inline irt::M44d HdIrtMatrix(const GfMatrix4d& m) {
    irt::M44d out;
    static_assert(sizeof(out) == 16 * sizeof(double));
    std::memcpy(&out[0][0], m.GetArray(), sizeof(out));
    return out;
}

inline irt::V3f HdIrtVector(const GfVec3f& v) { return {v[0], v[1], v[2]}; }

inline std::vector<irt::V3f> HdIrtVectors(const VtArray<GfVec3f>& array) {
    static_assert(sizeof(irt::V3f) == sizeof(GfVec3f));
    const auto* data = reinterpret_cast<const irt::V3f*>(array.cdata());
    return {data, data + array.size()};
}

template <class T>
std::vector<T> HdIrtArray(const VtArray<T>& array) {
    return {array.cdata(), array.cdata() + array.size()};
}

/// The prim that an id of the render index stands for: ids begin with their delegate's.
inline std::string HdIrtName(const HdSceneDelegate& delegate, const SdfPath& id) {
    const SdfPath& root = delegate.GetDelegateID();
    if (root.IsEmpty() || root == SdfPath::AbsoluteRootPath() || !id.HasPrefix(root))
        return id.GetString();
    return id.ReplacePrefix(root, SdfPath::AbsoluteRootPath()).GetString();
}

PXR_NAMESPACE_CLOSE_SCOPE
