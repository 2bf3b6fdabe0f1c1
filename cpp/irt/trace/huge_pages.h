// SPDX-License-Identifier: Apache-2.0
// Memory for large arrays: on huge pages where the system grants them on request.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

namespace irt::trace {

inline constexpr std::size_t huge_page = std::size_t{1} << 21;

/// Whole huge pages of fresh memory, straight from the system: what malloc hands out again may lie
/// on small pages already. `bytes` is rounded up. Throws std::bad_alloc.
inline void* map_huge(std::size_t bytes) {
    bytes = (bytes + huge_page - 1) / huge_page * huge_page;
    void* mapped = ::mmap(nullptr, bytes + huge_page, PROT_READ | PROT_WRITE,
                          MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    auto* start = static_cast<std::byte*>(mapped);
    const std::size_t past = reinterpret_cast<std::uintptr_t>(start) % huge_page;
    const std::size_t head = past == 0 ? 0 : huge_page - past;
    if (head > 0) ::munmap(start, head);
    ::munmap(start + head + bytes, huge_page - head);
    ::madvise(start + head, bytes, MADV_HUGEPAGE);  // advice: may be refused
    return start + head;
}

inline void unmap_huge(void* memory, std::size_t bytes) {
    ::munmap(memory, (bytes + huge_page - 1) / huge_page * huge_page);
}

/// Allocator of huge pages for what is at least half of one; else of cache lines.
template <class T>
struct HugePages {
    using value_type = T;
    static constexpr std::size_t line = 64;

    HugePages() = default;
    template <class U>
    HugePages(const HugePages<U>&) {}

    T* allocate(std::size_t count) {
        const std::size_t bytes = count * sizeof(T);
        if (bytes >= huge_page / 2) return static_cast<T*>(map_huge(bytes));
        void* memory = std::aligned_alloc(line, (bytes + line - 1) / line * line);
        if (!memory) throw std::bad_alloc();
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count) {
        if (count * sizeof(T) >= huge_page / 2)
            unmap_huge(memory, count * sizeof(T));
        else
            std::free(memory);
    }

    bool operator==(const HugePages&) const = default;
};

}  // namespace irt::trace
