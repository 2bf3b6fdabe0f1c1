// SPDX-License-Identifier: Apache-2.0
// Memory for large arrays read at random: on huge pages where the system grants them on request.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace irt::trace {

/// Allocator of whole, aligned huge pages for what is at least half of one; else of cache lines.
template <class T>
struct HugePages {
    using value_type = T;
    static constexpr std::size_t page = std::size_t{1} << 21, line = 64;

    HugePages() = default;
    template <class U>
    HugePages(const HugePages<U>&) {}

    T* allocate(std::size_t count) {
        const std::size_t alignment = count * sizeof(T) >= page / 2 ? page : line;
        const std::size_t bytes = (count * sizeof(T) + alignment - 1) / alignment * alignment;
        void* memory = std::aligned_alloc(alignment, bytes);
        if (!memory) throw std::bad_alloc();
        if (alignment == page) ::madvise(memory, bytes, MADV_HUGEPAGE);  // advice: may be refused
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t) { std::free(memory); }

    bool operator==(const HugePages&) const = default;
};

/// Memory that nothing is constructed in, from HugePages.
struct FreeBytes {
    void operator()(std::byte* memory) const { std::free(memory); }
};
using HugeBytes = std::unique_ptr<std::byte, FreeBytes>;
inline HugeBytes huge_bytes(std::size_t count) {
    return HugeBytes(HugePages<std::byte>().allocate(count));
}

}  // namespace irt::trace
