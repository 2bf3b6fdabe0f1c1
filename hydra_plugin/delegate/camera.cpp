// SPDX-License-Identifier: Apache-2.0
#include "delegate/camera.h"

#include <charconv>
#include <cmath>
#include <cstring>

#include "delegate/convert.h"
#include "pxr/base/gf/camera.h"
#include "pxr/imaging/hd/camera.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// How many digits `value` takes to be read back as it is.
std::ptrdiff_t Digits(float value) {
    char text[32];
    return std::to_chars(text, text + sizeof(text), value).ptr - text;
}

/// The attribute that Hydra's value of a lens is `scaled` of: it multiplies by a tenth, in single
/// precision, and rounds. Of several that round alike the one of fewest digits.
double Authored(float scaled) {
    const auto tenth = static_cast<float>(GfCamera::APERTURE_UNIT);
    const float near = scaled / tenth;
    float best = near;
    bool found = false;
    float candidate = std::nextafter(std::nextafter(near, -HUGE_VALF), -HUGE_VALF);
    for (int i = 0; i < 5; ++i, candidate = std::nextafter(candidate, HUGE_VALF)) {
        if (candidate * tenth != scaled) continue;
        if (!found || Digits(candidate) < Digits(best)) best = candidate;
        found = true;
    }
    return best;
}

struct Aperture {
    double width, height;
};

/// UsdRender's aspectRatioConformPolicy, which CameraUtil has under other names.
Aperture Conformed(const Aperture& aperture, double image_aspect,
                   CameraUtilConformWindowPolicy policy) {
    const bool wide = aperture.width / aperture.height > image_aspect;
    bool narrows = true;
    switch (policy) {
        case CameraUtilMatchVertically:
            break;
        case CameraUtilMatchHorizontally:
            narrows = false;
            break;
        case CameraUtilFit:
            narrows = !wide;
            break;
        case CameraUtilCrop:
            narrows = wide;
            break;
        default:
            return aperture;
    }
    if (narrows) return {aperture.height * image_aspect, aperture.height};
    return {aperture.width, aperture.width / image_aspect};
}

bool Positive(double value) { return std::isfinite(value) && value > 0; }

/// The schema's own clipping range is no statement about a scene.
bool IsDefault(const GfRange1f& clipping) {
    return clipping.GetMin() == 1.0f && clipping.GetMax() == 1000000.0f;
}

bool Fill(const HdCamera& camera, double image_aspect, CameraUtilConformWindowPolicy policy,
          irt::Camera& out) {
    out.world_from_camera = HdIrtMatrix(camera.GetTransform());
    out.orthographic = camera.GetProjection() == HdCamera::Orthographic;
    const Aperture authored{Authored(camera.GetHorizontalAperture()),
                            Authored(camera.GetVerticalAperture())};
    if (!Positive(authored.width)) return false;
    if (policy != CameraUtilMatchHorizontally && !Positive(authored.height)) return false;
    const auto [width, height] = Conformed(authored, image_aspect, policy);
    double scale = GfCamera::APERTURE_UNIT;
    if (!out.orthographic) {
        const double focal = Authored(camera.GetFocalLength());
        if (!Positive(focal)) return false;
        scale = 1 / focal;
    }
    const double x = Authored(camera.GetHorizontalApertureOffset());
    const double y = Authored(camera.GetVerticalApertureOffset());
    out.window = {(x - width / 2) * scale, (x + width / 2) * scale, (y - height / 2) * scale,
                  (y + height / 2) * scale};
    const GfRange1f& clipping = camera.GetClippingRange();
    if (!clipping.IsEmpty() && !IsDefault(clipping) && clipping.GetMin() >= 0 &&
        clipping.GetMax() > clipping.GetMin()) {
        out.near = clipping.GetMin();
        out.far = clipping.GetMax();
    }
    return true;
}

/// Of hosts that give matrices alone.
bool Fill(const GfMatrix4d& view, const GfMatrix4d& projection, irt::Camera& out) {
    double determinant = 0;
    out.world_from_camera = HdIrtMatrix(view.GetInverse(&determinant));
    if (determinant == 0 || !std::isfinite(determinant)) return false;
    const GfMatrix4d& p = projection;
    if (!std::isfinite(p[0][0]) || !std::isfinite(p[1][1]) || p[0][0] == 0 || p[1][1] == 0)
        return false;
    out.orthographic = p[2][3] == 0;
    const int row = out.orthographic ? 3 : 2;
    const double sign = out.orthographic ? -1 : 1;
    out.window = {(sign * p[row][0] - 1) / p[0][0], (sign * p[row][0] + 1) / p[0][0],
                  (sign * p[row][1] - 1) / p[1][1], (sign * p[row][1] + 1) / p[1][1]};
    return true;
}

/// Both ends are in.
void Window(const GfRect2i& rect, int& x, int& y, int& width, int& height) {
    x = rect.GetMinX();
    y = rect.GetMinY();
    width = rect.GetWidth();
    height = rect.GetHeight();
}

}  // namespace

std::optional<HdIrtSight> HdIrtSightOf(const HdRenderPassState& state) {
    HdIrtSight sight;
    const CameraUtilFraming& framing = state.GetFraming();
    double pixel_aspect = 1;
    if (framing.IsValid()) {
        const GfVec2f size = framing.displayWindow.GetSize();
        sight.frame_width = static_cast<int>(std::lround(size[0]));
        sight.frame_height = static_cast<int>(std::lround(size[1]));
        pixel_aspect = framing.pixelAspectRatio;
        Window(framing.dataWindow, sight.x, sight.y, sight.width, sight.height);
        sight.x -= static_cast<int>(std::lround(framing.displayWindow.GetMin()[0]));
        sight.y -= static_cast<int>(std::lround(framing.displayWindow.GetMin()[1]));
    } else {
        const GfVec4f& viewport = state.GetViewport();
        if (!std::isfinite(viewport[2]) || !std::isfinite(viewport[3])) return std::nullopt;
        sight.frame_width = sight.width = static_cast<int>(viewport[2]);
        sight.frame_height = sight.height = static_cast<int>(viewport[3]);
    }
    constexpr int maxSide = 65536;
    for (const int side : {sight.frame_width, sight.frame_height, sight.width, sight.height})
        if (side < 1 || side > maxSide) return std::nullopt;
    const HdCamera* camera = state.GetCamera();
    const double image_aspect = pixel_aspect * (static_cast<double>(sight.frame_width) /
                                                static_cast<double>(sight.frame_height));
    const bool seen =
        camera ? Fill(*camera, image_aspect, state.GetWindowPolicy(), sight.camera)
               : Fill(state.GetWorldToViewMatrix(), state.GetProjectionMatrix(), sight.camera);
    if (!seen) return std::nullopt;
    if (camera && camera->GetExposure() != 0) sight.exposure = std::exp2(camera->GetExposure());
    return sight;
}

PXR_NAMESPACE_CLOSE_SCOPE
