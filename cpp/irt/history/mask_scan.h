// SPDX-License-Identifier: Apache-2.0
// The texture masks of a cell (paper, section 4.2) looked through, 32 at a time.
#pragma once

#include <immintrin.h>

#include <bit>
#include <cstdint>
#include <span>

namespace irt::history {

/// Calls found(i) for each i, in order, of which bits[i] is the number of a bit set in `mask`.
template <class Found>
void for_each_masked(std::span<const std::uint8_t> bits, std::uint64_t mask, Found&& found) {
    constexpr std::size_t step = 32;
    std::size_t i = 0;
    for (; i + step <= bits.size(); i += step) {
        const __m256i chunk = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bits.data() + i));
        __m256i hit = _mm256_setzero_si256();
        for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1)
            hit = _mm256_or_si256(
                hit, _mm256_cmpeq_epi8(
                         chunk, _mm256_set1_epi8(static_cast<char>(std::countr_zero(rest)))));
        auto set = static_cast<unsigned>(_mm256_movemask_epi8(hit));
        for (; set != 0; set &= set - 1) found(i + static_cast<std::size_t>(std::countr_zero(set)));
    }
    for (; i < bits.size(); ++i)
        if (bits[i] < 64 && (mask >> bits[i] & 1)) found(i);
}

}  // namespace irt::history
