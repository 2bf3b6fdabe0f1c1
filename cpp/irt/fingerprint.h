// SPDX-License-Identifier: Apache-2.0
// The numeric fingerprint of a host (DESIGN 3, rule 11).
#pragma once

#include <map>
#include <string>

namespace irt {

/// Hash over the bits of fixed rays through a fixed scene and of fixed libm calls, under `isa`, as
/// 16 hexadecimal digits. Hosts of equal fingerprint render equal bits. Throws
/// std::invalid_argument if this processor lacks `isa`.
std::string numeric_fingerprint(const std::string& isa);

/// Versions of irt, the libraries its core was built with, and the compiler.
std::map<std::string, std::string> versions();

}  // namespace irt
