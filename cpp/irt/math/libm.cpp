// SPDX-License-Identifier: Apache-2.0
#include "irt/math/libm.h"

#include <cmath>

namespace irt::libm {

double log2(double x) { return std::log2(x); }
double exp2(double x) { return std::exp2(x); }

}  // namespace irt::libm
