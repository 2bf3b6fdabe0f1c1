// SPDX-License-Identifier: Apache-2.0
#include "delegate/points.h"

#include "delegate/pointBased.h"

PXR_NAMESPACE_OPEN_SCOPE

bool HdIrtPoints::_ReadGeometry(HdSceneDelegate& delegate, const std::set<std::string>& wanted,
                                HdIrtShape& shape) {
    const std::optional<std::vector<irt::V3f>> points = HdIrtReadPoints(delegate, GetId());
    if (!points) return false;
    const auto count = [&](irt::Interpolation interpolation) -> std::size_t {
        const bool one = interpolation == irt::Interpolation::Constant ||
                         interpolation == irt::Interpolation::Uniform;
        return one ? 1 : points->size();
    };
    const std::optional<HdIrtWidths> widths = HdIrtReadWidths(delegate, GetId(), count);
    if (!widths) return false;
    auto spheres = std::make_shared<irt::Spheres>();
    for (std::size_t i = 0; i < points->size(); ++i) {
        const float width = widths->values[widths->values.size() == 1 ? 0 : i];
        spheres->balls.push_back({(*points)[i], width / 2});
    }
    spheres->primvars = HdIrtReadPrimvars(delegate, GetId(), wanted, count);
    for (irt::Primvar& primvar : spheres->primvars)
        if (primvar.interpolation == irt::Interpolation::FaceVarying ||
            primvar.interpolation == irt::Interpolation::Varying)
            primvar.interpolation = irt::Interpolation::Vertex;
    shape.geometry = std::shared_ptr<const irt::Spheres>(std::move(spheres));
    return true;
}

PXR_NAMESPACE_CLOSE_SCOPE
