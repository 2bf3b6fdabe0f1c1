// SPDX-License-Identifier: Apache-2.0
// The floating-point state a task computes under (DESIGN 3, rule 11).
#pragma once

#include <xmmintrin.h>

namespace irt {

/// Sets MXCSR to round-to-nearest, all exceptions masked, flush-to-zero and denormals-are-zero off
/// for the life of the object, and restores what the host had. Wraps every task that computes.
class FloatState {
  public:
    FloatState() : saved_(_mm_getcsr()) { _mm_setcsr(ieee_default); }
    ~FloatState() { _mm_setcsr(saved_); }
    FloatState(const FloatState&) = delete;
    FloatState& operator=(const FloatState&) = delete;

  private:
    static constexpr unsigned ieee_default = 0x1f80;
    unsigned saved_;
};

}  // namespace irt
