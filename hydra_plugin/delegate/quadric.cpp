// SPDX-License-Identifier: Apache-2.0
#include "delegate/quadric.h"

#include <cmath>

#include "pxr/base/tf/diagnostic.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_DEFINE_PRIVATE_TOKENS(_tokens, (radius)(size)(height)(axis)(X)(Y));

bool HdIrtQuadric::Draws(const TfToken& type) {
    return type == HdPrimTypeTokens->sphere || type == HdPrimTypeTokens->cube ||
           type == HdPrimTypeTokens->cone || type == HdPrimTypeTokens->cylinder ||
           type == HdPrimTypeTokens->capsule;
}

bool HdIrtQuadric::_ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                                 HdIrtShape& shape) {
    // A capsule without height is a ball; of anything else a length of 0 means that it is not
    // there.
    bool there = true;
    const auto length = [&](const TfToken& name, double otherwise, bool may_be_zero) {
        const VtValue value = VtValue::Cast<double>(delegate.Get(GetId(), name));
        const double number = value.GetWithDefault<double>(otherwise);
        if (!std::isfinite(number) || number < 0) {
            TF_WARN("<%s>: its %s is %g; expected a positive finite number; it is not drawn",
                    GetId().GetText(), name.GetText(), number);
            there = false;
        }
        if (number == 0 && !may_be_zero) there = false;
        return number;
    };
    const TfToken axis = delegate.Get(GetId(), _tokens->axis).GetWithDefault<TfToken>(TfToken("Z"));
    // Cyclic, so that hands are kept.
    _turn.SetIdentity();
    if (axis == _tokens->X) _turn.Set(0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1);
    if (axis == _tokens->Y) _turn.Set(0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1);
    irt::Quadric quadric;
    if (_type == HdPrimTypeTokens->cube) {
        quadric.kind = irt::QuadricKind::Cube;
        quadric.size = length(_tokens->size, 2, false);
    } else {
        quadric.radius = length(_tokens->radius, 1, false);
        if (_type != HdPrimTypeTokens->sphere) {
            const bool capsule = _type == HdPrimTypeTokens->capsule;
            quadric.height = length(_tokens->height, capsule ? 1 : 2, capsule);
            if (_type == HdPrimTypeTokens->cone) quadric.kind = irt::QuadricKind::Cone;
            if (_type == HdPrimTypeTokens->cylinder) quadric.kind = irt::QuadricKind::Cylinder;
            if (capsule && quadric.height > 0) quadric.kind = irt::QuadricKind::Capsule;
            if (capsule && quadric.height == 0) quadric.height = 2;
        }
    }
    shape.geometry = quadric;
    shape.primvars = HdIrtConstantPrimvars(delegate, GetId(), wanted);
    return there;
}

PXR_NAMESPACE_CLOSE_SCOPE
