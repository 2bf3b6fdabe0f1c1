// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "delegate/shapePrim.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Round tubes along linear and cubic curves.
class HdIrtCurves final : public HdIrtShapePrim {
  public:
    explicit HdIrtCurves(const SdfPath& id) : HdIrtShapePrim(id) {}

  private:
    bool _ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                       HdIrtShape& shape) override;
};

PXR_NAMESPACE_CLOSE_SCOPE
