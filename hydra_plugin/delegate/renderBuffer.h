// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "delegate/pixels.h"
#include "pxr/imaging/hd/renderBuffer.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Row 0 is the lowest one, as Hydra has it.
class HdIrtRenderBuffer final : public HdRenderBuffer {
  public:
    explicit HdIrtRenderBuffer(const SdfPath& id) : HdRenderBuffer(id) { _Deallocate(); }

    bool Allocate(const GfVec3i& dimensions, HdFormat format, bool multiSampled) override;
    unsigned int GetWidth() const override { return static_cast<unsigned>(_pixels->width); }
    unsigned int GetHeight() const override { return static_cast<unsigned>(_pixels->height); }
    unsigned int GetDepth() const override { return 1; }
    HdFormat GetFormat() const override { return _pixels->format; }
    bool IsMultiSampled() const override { return false; }
    void* Map() override { return _pixels->Map(); }
    void Unmap() override { _pixels->Unmap(); }
    bool IsMapped() const override { return _pixels->IsMapped(); }
    void Resolve() override {}
    bool IsConverged() const override { return _pixels->converged; }

    /// Those of the last Allocate; they outlive the buffer while the render thread has them.
    [[nodiscard]] const std::shared_ptr<HdIrtPixels>& Pixels() const { return _pixels; }

  private:
    void _Deallocate() override { _pixels = std::make_shared<HdIrtPixels>(0, 0, HdFormatInvalid); }

    std::shared_ptr<HdIrtPixels> _pixels;
};

PXR_NAMESPACE_CLOSE_SCOPE
