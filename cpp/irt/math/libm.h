// SPDX-License-Identifier: Apache-2.0
// The only door to libm (DESIGN 3, rule 11). Out of line, so that no compiler folds or vectorises a
// call; the numeric fingerprint hashes their values, because libraries differ in the last bit.
// Square roots, sums and products are exact by IEEE 754 and need no door.
#pragma once

namespace irt::libm {

double log2(double x);
double exp2(double x);
double pow(double x, double y);
double exp(double x);
double log(double x);
double sin(double x);
double cos(double x);
double asin(double x);
double acos(double x);
double atan2(double y, double x);

}  // namespace irt::libm
