// SPDX-License-Identifier: Apache-2.0
// The pixels of a render buffer, shared by the host's thread, which maps them, and the render
// thread, which replaces them; neither waits for more than a swap.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "pxr/imaging/hd/types.h"

PXR_NAMESPACE_OPEN_SCOPE

class HdIrtPixels {
  public:
    HdIrtPixels(int pixelWidth, int pixelHeight, HdFormat pixelFormat)
        : width(pixelWidth), height(pixelHeight), format(pixelFormat), _shown(Size(), 0) {}

    const int width, height;
    const HdFormat format;
    std::atomic<bool> converged = false;

    [[nodiscard]] std::size_t Size() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
               HdDataSizeOfFormat(format);
    }
    /// Takes `bytes`, of Size(), for the next Map; leaves some memory to write the next ones into.
    void Replace(std::vector<std::uint8_t>& bytes) {
        const std::lock_guard lock(_mutex);
        std::swap(_mappers == 0 ? _shown : _next, bytes);
        _hasNext = _mappers != 0;
    }
    std::uint8_t* Map() {
        const std::lock_guard lock(_mutex);
        ++_mappers;
        return _shown.data();
    }
    void Unmap() {
        const std::lock_guard lock(_mutex);
        if (_mappers == 0 || --_mappers != 0 || !_hasNext) return;
        std::swap(_shown, _next);
        _hasNext = false;
    }
    [[nodiscard]] bool IsMapped() const {
        const std::lock_guard lock(_mutex);
        return _mappers != 0;
    }

  private:
    mutable std::mutex _mutex;
    std::vector<std::uint8_t> _shown, _next;
    bool _hasNext = false;
    int _mappers = 0;
};

PXR_NAMESPACE_CLOSE_SCOPE
