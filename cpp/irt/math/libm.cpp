// SPDX-License-Identifier: Apache-2.0
#include "irt/math/libm.h"

#include <cmath>

namespace irt::libm {

double log2(double x) { return std::log2(x); }
double exp2(double x) { return std::exp2(x); }
double pow(double x, double y) { return std::pow(x, y); }
double exp(double x) { return std::exp(x); }
double log(double x) { return std::log(x); }
double sin(double x) { return std::sin(x); }
double cos(double x) { return std::cos(x); }
double asin(double x) { return std::asin(x); }
double acos(double x) { return std::acos(x); }
double atan2(double y, double x) { return std::atan2(y, x); }

}  // namespace irt::libm
