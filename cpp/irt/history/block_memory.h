// SPDX-License-Identifier: Apache-2.0
// Memory for the cells that one task records: one block on huge pages, cut up once.
#pragma once

#include <cstddef>
#include <memory_resource>

#include "irt/trace/huge_pages.h"

namespace irt::history {

/// While it is open, on one thread, it serves from the block as long as that lasts; else, and once
/// sealed, from the heap, on any thread. What was cut from the block comes back with it alone.
class BlockMemory final : public std::pmr::memory_resource {
  public:
    /// Makes a block of at least `size` bytes; nothing of the last one may still be in use.
    void open(std::size_t size) {
        if (size_ < size) {
            block_ = trace::huge_bytes(size);
            size_ = size;
        }
        used_ = 0;
        open_ = true;
    }
    void seal() { open_ = false; }

  private:
    void* do_allocate(std::size_t bytes, std::size_t alignment) override {
        const std::size_t start = (used_ + alignment - 1) / alignment * alignment;
        if (!open_ || start + bytes > size_) return heap()->allocate(bytes, alignment);
        used_ = start + bytes;
        return block_.get() + start;
    }
    void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
        const auto* byte = static_cast<const std::byte*>(memory);
        if (byte < block_.get() || byte >= block_.get() + size_)
            heap()->deallocate(memory, bytes, alignment);
    }
    bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
        return this == &other;
    }
    static std::pmr::memory_resource* heap() { return std::pmr::new_delete_resource(); }

    trace::HugeBytes block_;
    std::size_t size_ = 0, used_ = 0;
    bool open_ = false;
};

}  // namespace irt::history
