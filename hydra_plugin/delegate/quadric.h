// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "delegate/shapePrim.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Spheres, cubes, cones, cylinders and capsules, exact; the core's lie along z, and are turned.
class HdIrtQuadric final : public HdIrtShapePrim {
  public:
    HdIrtQuadric(const TfToken& type, const SdfPath& id) : HdIrtShapePrim(id), _type(type) {}
    static bool Draws(const TfToken& type);

  private:
    bool _ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                       HdIrtShape& shape) override;
    HdDirtyBits _GeometryBits() const override { return HdChangeTracker::AllSceneDirtyBits; }

    TfToken _type;
};

PXR_NAMESPACE_CLOSE_SCOPE
