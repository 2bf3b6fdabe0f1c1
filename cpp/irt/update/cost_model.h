// SPDX-License-Identifier: Apache-2.0
// Whether an update is worth its while. It counts work, never seconds, so that runs repeat (DESIGN
// 3, rule 13); it chooses between ways to one film.
#pragma once

#include <cstdint>
#include <string>

#include "irt/update/cell_update.h"

namespace irt::update {

/// Work in units of a full trace's cost for each of its rays, shading and film included. A new ray
/// costs its place in the history, too. The weights were fitted to shots/paper with 2 to 100 % of
/// its objects moved (docs/measurements.md, "Cost model").
[[nodiscard]] inline double work(const UpdateCounts& counts) {
    return 0.55 * static_cast<double>(counts.rays.rays()) +
           1.1 * static_cast<double>(counts.rays.shadings) +
           2.2 * static_cast<double>(counts.new_rays) + 0.17 * static_cast<double>(counts.tested);
}

/// Updates that flag fewer of all rays are not looked at: they cannot cost more than a full trace.
inline constexpr double least_flagged = 0.15;

/// Share of a full trace from which an update gives way to one.
inline constexpr double most_work = 0.9;

/// When a history is recorded again after updates were not worth it: recording costs about a third
/// of a full trace, so it waits, twice as long each time.
class Backoff {
  public:
    void update_paid() { failures_ = 0; }
    void update_failed() {
        failures_ = failures_ < most_failures ? failures_ + 1 : most_failures;
        wait_ = (std::uint32_t{4} << failures_) - 1;
    }
    /// Whether the next full trace records; counts it.
    [[nodiscard]] bool record() {
        if (wait_ == 0) return true;
        --wait_;
        return false;
    }

    /// For checkpoints (checkpoint/arrays.h).
    template <class Archive, class Self>
    static void archive(Archive& to, const std::string& name, Self& self) {
        auto& [failures, wait] = self;
        to.value(name + "failures", failures);
        to.value(name + "wait", wait);
    }

  private:
    static constexpr std::uint32_t most_failures = 8;
    std::uint32_t failures_ = 0, wait_ = 0;
};

}  // namespace irt::update
