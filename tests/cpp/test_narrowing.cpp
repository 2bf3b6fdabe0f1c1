// SPDX-License-Identifier: Apache-2.0
// What the ray tree rounds to single precision has to be rounded, whatever is computed from it
// next. GCC 12.2 at -O2 with its SLP vectoriser leaves the rounding out of the first two lanes
// here, which made a branch's weight differ between two functions that compute it alike.
#include <gtest/gtest.h>

#include <algorithm>

#include "irt/math/vec.h"

namespace irt {
namespace {

[[gnu::noinline]] bool narrowed(const V3d& weight, V3d& out) {
    const V3f share(weight);
    if (std::max({share.x, share.y, share.z}) <= 0) return false;
    out = V3d(share);
    return true;
}

TEST(Narrowing, RoundsEveryLane) {
    V3d out;
    ASSERT_TRUE(narrowed({0.1, 0.2, 0.3}, out));
    EXPECT_EQ(out, V3d(0x1.99999ap-4, 0x1.99999ap-3, 0x1.333334p-2));
}

[[gnu::noinline]] void narrowed(const double* in, double* out, int count) {
    for (int i = 0; i < count; ++i) out[i] = static_cast<double>(static_cast<float>(in[i]));
}

TEST(Narrowing, RoundsInLoops) {
    const double in[5] = {0.1, 0.2, 0.1, 0.2, 0.1};
    double out[5];
    narrowed(in, out, 5);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(out[i], i % 2 == 0 ? 0x1.99999ap-4 : 0x1.99999ap-3);
}

}  // namespace
}  // namespace irt
