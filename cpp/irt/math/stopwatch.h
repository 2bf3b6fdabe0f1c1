// SPDX-License-Identifier: Apache-2.0
// Seconds by the clock.
#pragma once

#include <chrono>

namespace irt {

class Stopwatch {
  public:
    /// Seconds since construction or the last call.
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const std::chrono::duration<double> elapsed = now - start_;
        start_ = now;
        return elapsed.count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace irt
