// SPDX-License-Identifier: Apache-2.0
#include "delegate/renderBuffer.h"

#include "pxr/base/gf/vec3i.h"
#include "pxr/base/tf/diagnostic.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {
/// Pixels a side; wider ones are taken for mistakes.
constexpr int maxSide = 65536;
}  // namespace

bool HdIrtRenderBuffer::Allocate(const GfVec3i& dimensions, HdFormat format,
                                 bool /*multiSampled*/) {
    _Deallocate();
    const int width = dimensions[0], height = dimensions[1];
    if (width < 0 || height < 0 || width > maxSide || height > maxSide || dimensions[2] != 1) {
        TF_WARN("<%s>: a render buffer of %d x %d x %d; expected 0 to %d a side, and a depth of 1",
                GetId().GetText(), width, height, dimensions[2], maxSide);
        return false;
    }
    if (format <= HdFormatInvalid || format >= HdFormatCount || HdDataSizeOfFormat(format) == 0) {
        TF_WARN("<%s>: a render buffer of format %d; expected one of HdFormat", GetId().GetText(),
                static_cast<int>(format));
        return false;
    }
    _pixels = std::make_shared<HdIrtPixels>(width, height, format);
    return true;
}

PXR_NAMESPACE_CLOSE_SCOPE
