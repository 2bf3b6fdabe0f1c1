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
    BlockMemory() = default;
    ~BlockMemory() override { release(); }
    BlockMemory(const BlockMemory&) = delete;
    BlockMemory& operator=(const BlockMemory&) = delete;

    /// Makes a block of at least `size` bytes; nothing of the last one may still be in use.
    void open(std::size_t size) {
        if (size_ < size) {
            release();
            block_ = static_cast<std::byte*>(trace::map_huge(size));
            size_ = size;
        }
        used_ = 0;
        open_ = true;
    }
    void seal() { open_ = false; }

  private:
    void release() {
        if (block_) trace::unmap_huge(block_, size_);
        block_ = nullptr;
        size_ = 0;
    }
    void* do_allocate(std::size_t bytes, std::size_t alignment) override {
        const std::size_t start = (used_ + alignment - 1) / alignment * alignment;
        if (!open_ || start + bytes > size_) return heap()->allocate(bytes, alignment);
        used_ = start + bytes;
        return block_ + start;
    }
    void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
        const auto* byte = static_cast<const std::byte*>(memory);
        if (!block_ || byte < block_ || byte >= block_ + size_)
            heap()->deallocate(memory, bytes, alignment);
    }
    bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
        return this == &other;
    }
    static std::pmr::memory_resource* heap() { return std::pmr::new_delete_resource(); }

    std::byte* block_ = nullptr;
    std::size_t size_ = 0, used_ = 0;
    bool open_ = false;
};

}  // namespace irt::history
