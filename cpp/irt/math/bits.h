// SPDX-License-Identifier: Apache-2.0
// Equality by bytes: 0.0 and -0.0 differ, a NaN equals itself (DESIGN 3, rules 6 and 9).
#pragma once

#include <cstring>
#include <type_traits>
#include <vector>

namespace irt {

/// Records whose bytes are their value. (Imath's vectors are not trivially copyable by the letter:
/// their copy constructors are written out.)
template <class T>
inline constexpr bool is_plain = std::is_standard_layout_v<T>&& std::is_trivially_destructible_v<T>;

template <class T>
bool same_bits(const T& a, const T& b) {
    static_assert(is_plain<T>);
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    static_assert(is_plain<T>);
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace irt
