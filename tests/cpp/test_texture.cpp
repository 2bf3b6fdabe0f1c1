// SPDX-License-Identifier: Apache-2.0
// Textures against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <stdexcept>

#include "irt/texture/filter.h"
#include "irt/texture/texel.h"

namespace irt::texture {
namespace {

constexpr std::array<double, 9> identity{1, 0, 0, 0, 1, 0, 0, 0, 1};

template <class T>
Tile tile(int width, int height, int channels, TexelFormat format, const std::vector<T>& values) {
    const std::shared_ptr<std::byte[]> bytes(new std::byte[values.size() * sizeof(T)]);
    std::memcpy(bytes.get(), values.data(), values.size() * sizeof(T));
    Tile out;
    out.channels = channels;
    out.format = format;
    out.levels.push_back({width, height, {bytes, bytes.get()}});
    return out;
}

/// A square image of one channel of floats.
Texture grey(int size, const std::vector<float>& values) {
    return {{tile(size, size, 1, TexelFormat::Float, values)}, Transfer::Linear, identity, false};
}

Texture noise(int width, int height) {
    std::mt19937 random(1);
    std::vector<float> values(static_cast<std::size_t>(width * height));
    for (float& v : values) v = std::uniform_real_distribution<float>(0, 1)(random);
    return {
        {tile(width, height, 1, TexelFormat::Float, values)}, Transfer::Linear, identity, false};
}

double value(const Texture& texture, const V2d& st, Wrap wrap, const V2d& dx = {0, 0},
             const V2d& dy = {0, 0}) {
    return (*look_up(texture, wrap, wrap, st, dx, dy))[0];
}

double texel(const Tile& t, std::size_t level, int x, int y) {
    const Image& image = t.levels[level];
    return decode<TexelFormat::Float>(
        image.texels.get() + 4 * static_cast<std::size_t>(y * image.width + x), Transfer::Linear);
}

TEST(Texture, TexelCentresGiveTexelsAndTheFirstRowIsOnTop) {
    const Texture texture = grey(4, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            for (const Wrap wrap : {Wrap::Black, Wrap::Clamp, Wrap::Repeat, Wrap::Mirror})
                EXPECT_EQ(value(texture, {(x + 0.5) / 4, 1 - (y + 0.5) / 4}, wrap), 4 * y + x);
}

TEST(Texture, BetweenCentresItIsBilinear) {
    const Texture texture = grey(2, {0, 1, 2, 5});
    EXPECT_DOUBLE_EQ(value(texture, {0.5, 0.5}, Wrap::Clamp), 2);
    EXPECT_DOUBLE_EQ(value(texture, {0.375, 0.75}, Wrap::Clamp), 0.25);
    EXPECT_DOUBLE_EQ(value(texture, {0.375, 0.375}, Wrap::Clamp),
                     0.25 * 0.25 * 1 + 0.75 * (0.75 * 2 + 0.25 * 5));
}

TEST(Texture, WrapsAreThoseOfUsdUvTexture) {
    const Texture texture = grey(2, {0, 1, 2, 5});
    const double s = 0.25, t = 0.25;  // the centre of the lower left texel: 2
    EXPECT_EQ(value(texture, {s + 1, t}, Wrap::Repeat), 2);
    EXPECT_EQ(value(texture, {s - 3, t + 7}, Wrap::Repeat), 2);
    EXPECT_EQ(value(texture, {s + 1, t}, Wrap::Mirror), 5);
    EXPECT_EQ(value(texture, {s + 2, t}, Wrap::Mirror), 2);
    EXPECT_EQ(value(texture, {-s, -t}, Wrap::Mirror), 2);
    EXPECT_EQ(value(texture, {-5, -5}, Wrap::Clamp), 2);
    EXPECT_EQ(value(texture, {9, 9}, Wrap::Clamp), 1);
    EXPECT_EQ(value(texture, {1.25, 0.25}, Wrap::Black), 0);
    EXPECT_EQ(value(texture, {1e30, 0.25}, Wrap::Black), 0);
    EXPECT_DOUBLE_EQ(value(texture, {1, 0.25}, Wrap::Black), 2.5) << "the border is half-way";
    EXPECT_DOUBLE_EQ(value(texture, {0, 0.25}, Wrap::Repeat), 3.5) << "over the seam";
    EXPECT_DOUBLE_EQ(value(texture, {0, 0.25}, Wrap::Mirror), 2);
}

TEST(Texture, RepeatAndMirrorArePeriodic) {
    const Texture texture = noise(7, 5);
    std::mt19937 random(2);
    std::uniform_int_distribution<int> k(-8, 8), sixteenth(0, 255);
    for (int trial = 0; trial < 200; ++trial) {
        const V2d st(sixteenth(random) / 256.0, sixteenth(random) / 256.0);
        const V2d whole(k(random), k(random));
        EXPECT_EQ(value(texture, st + whole, Wrap::Repeat), value(texture, st, Wrap::Repeat));
        EXPECT_EQ(value(texture, st + whole * 2, Wrap::Mirror), value(texture, st, Wrap::Mirror));
        EXPECT_NEAR(value(texture, -st, Wrap::Mirror), value(texture, st, Wrap::Mirror), 1e-15);
    }
}

TEST(Texture, StThatIsNoNumberHasNoValue) {
    const Texture texture = grey(1, {1});
    EXPECT_FALSE(look_up(texture, Wrap::Repeat, Wrap::Repeat, {NAN, 0}, {0, 0}, {0, 0}));
    EXPECT_FALSE(look_up(texture, Wrap::Repeat, Wrap::Repeat, {0, INFINITY}, {0, 0}, {0, 0}));
}

TEST(Texture, EveryLevelKeepsTheMeanWhateverTheSize) {
    for (const auto& [width, height] :
         {std::pair(8, 8), {7, 5}, {1, 9}, {6, 1}, {13, 32}, {3, 3}, {5, 11}}) {
        const Texture texture = noise(width, height);
        const Tile& t = texture.tiles()[0];
        const auto mean = [&](std::size_t level) {
            double sum = 0;
            const Image& image = t.levels[level];
            for (int y = 0; y < image.height; ++y)
                for (int x = 0; x < image.width; ++x) sum += texel(t, level, x, y);
            return sum / (image.width * image.height);
        };
        EXPECT_EQ(t.levels.back().width, 1);
        EXPECT_EQ(t.levels.back().height, 1);
        for (std::size_t level = 1; level < t.levels.size(); ++level) {
            EXPECT_EQ(t.levels[level].width, std::max(t.levels[level - 1].width / 2, 1));
            EXPECT_NEAR(mean(level), mean(0), 1e-6);
        }
    }
}

TEST(Texture, PyramidIsOfLinearLight) {
    // Black and white in equal parts: half the light, which sRGB writes as 188.
    std::vector<std::uint8_t> checks;
    for (int i = 0; i < 64; ++i) checks.push_back((i + i / 8) % 2 ? 255 : 0);
    const Texture texture({tile(8, 8, 1, TexelFormat::U8, checks)}, Transfer::Srgb, identity,
                          false);
    const Image& coarsest = texture.tiles()[0].levels.back();
    EXPECT_EQ(static_cast<int>(*coarsest.texels), 188);
    const Texture linear({tile(8, 8, 1, TexelFormat::U8, checks)}, Transfer::Linear, identity,
                         false);
    EXPECT_EQ(static_cast<int>(*linear.tiles()[0].levels.back().texels), 128);
}

TEST(Texture, AlphaIsLinearAlways) {
    const std::vector<std::uint8_t> values{128, 128, 128, 128};
    const Texture texture({tile(1, 1, 4, TexelFormat::U8, values)}, Transfer::Srgb, identity,
                          false);
    const Texel found = *look_up(texture, Wrap::Clamp, Wrap::Clamp, {0.5, 0.5}, {0, 0}, {0, 0});
    EXPECT_DOUBLE_EQ(found[0], std::pow((128 / 255.0 + 0.055) / 1.055, 2.4));
    EXPECT_EQ(found[3], 128 / 255.0);
}

TEST(Texture, ChannelsAreSpreadAsTheSpecificationSays) {
    const auto found = [](int channels) {
        const std::vector<float> values{0.25f, 0.5f, 0.75f, 0.125f};
        const Texture texture({tile(1, 1, channels, TexelFormat::Float, values)}, Transfer::Linear,
                              identity, false);
        return *look_up(texture, Wrap::Clamp, Wrap::Clamp, {0.5, 0.5}, {0, 0}, {0, 0});
    };
    EXPECT_EQ(found(1), (Texel{0.25, 0.25, 0.25, 1}));
    EXPECT_EQ(found(2), (Texel{0.25, 0.25, 0.25, 0.5}));
    EXPECT_EQ(found(3), (Texel{0.25, 0.5, 0.75, 1}));
    EXPECT_EQ(found(4), (Texel{0.25, 0.5, 0.75, 0.125}));
}

TEST(Texture, SrgbIsTheStandardsToTheLastCode) {
    EXPECT_EQ(srgb_to_linear(0), 0);
    EXPECT_EQ(srgb_to_linear(1), 1);
    EXPECT_DOUBLE_EQ(srgb_to_linear(0.04045), 0.04045 / 12.92);
    for (int code = 0; code < 256; ++code) {
        const double v = code / 255.0;
        const double expected = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        EXPECT_DOUBLE_EQ(srgb_codes_8()[static_cast<std::size_t>(code)], expected);
        // What is decoded, averaged with itself and encoded is the code again.
        const std::vector<std::uint8_t> two(2, static_cast<std::uint8_t>(code));
        const Texture texture({tile(2, 1, 1, TexelFormat::U8, two)}, Transfer::Srgb, identity,
                              false);
        EXPECT_EQ(static_cast<int>(*texture.tiles()[0].levels[1].texels), code);
    }
    for (std::size_t code = 0; code < 65536; code += 257)
        EXPECT_EQ(srgb_codes_16()[code], srgb_codes_8()[code / 257]);
}

TEST(Texture, EveryFormatDecodesToItsValue) {
    const std::vector<std::uint16_t> words{13107};
    const std::vector<half> halves{half(0.2f)};
    const auto found = [](const Tile& t) {
        const Texture texture({t}, Transfer::Linear, identity, false);
        return (*look_up(texture, Wrap::Clamp, Wrap::Clamp, {0.5, 0.5}, {0, 0}, {0, 0}))[0];
    };
    EXPECT_EQ(found(tile(1, 1, 1, TexelFormat::U16, words)), 0.2);
    EXPECT_EQ(found(tile(1, 1, 1, TexelFormat::Half, halves)),
              static_cast<double>(static_cast<float>(half(0.2f))));
    EXPECT_EQ(found(tile(1, 1, 1, TexelFormat::Float, std::vector<float>{0.2f})),
              static_cast<double>(0.2f));
}

TEST(Texture, MatrixIsAppliedAfterFiltering) {
    const std::vector<float> values{0.25f, 0.5f, 0.75f};
    const Texture texture({tile(1, 1, 3, TexelFormat::Float, values)}, Transfer::Linear,
                          {1, 2, 0, 0, 0, 1, 0.5, 0, 0}, false);
    EXPECT_EQ(*look_up(texture, Wrap::Clamp, Wrap::Clamp, {0.5, 0.5}, {0, 0}, {0, 0}),
              (Texel{1.25, 0.75, 0.125, 1}));
}

TEST(Filter, WholeImageIsItsMean) {
    const Texture texture = noise(64, 64);
    double mean = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) mean += texel(texture.tiles()[0], 0, x, y) / 4096;
    EXPECT_NEAR(value(texture, {0.3, 0.4}, Wrap::Repeat, {1, 0}, {0, 1}), mean, 1e-6);
    EXPECT_NEAR(value(texture, {0.3, 0.4}, Wrap::Repeat, {50, 3}, {-2, 40}), mean, 1e-6);
}

TEST(Filter, FootprintOfTwoPowersOfTexelsReadsThatLevel) {
    const Texture texture = noise(64, 64);
    for (int level = 0; level < 6; ++level) {
        const int size = 64 >> level;
        const double width = 1.0 / size;
        for (int x = 0; x < size; x += 3)
            EXPECT_DOUBLE_EQ(
                value(texture, {(x + 0.5) / size, 0.5 / size}, Wrap::Repeat, {width, 0},
                      {0, width}),
                texel(texture.tiles()[0], static_cast<std::size_t>(level), x, size - 1));
    }
}

TEST(Filter, DependsOnTheEllipseNotOnTheAxesThatSpanIt) {
    const Texture texture = noise(64, 64);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1), angle(0, 6.28);
    for (int trial = 0; trial < 100; ++trial) {
        const V2d st(unit(random), unit(random)), dx(0.2 * unit(random), 0.2 * unit(random)),
            dy(-0.05 * unit(random), 0.05 * unit(random));
        const double c = std::cos(angle(random)), s = std::sqrt(1 - c * c);
        EXPECT_NEAR(value(texture, st, Wrap::Repeat, dx, dy),
                    value(texture, st, Wrap::Repeat, dx * c + dy * s, dy * c - dx * s), 1e-9);
        EXPECT_EQ(value(texture, st, Wrap::Repeat, dx, dy),
                  value(texture, st, Wrap::Repeat, -dx, dy));
    }
}

TEST(Filter, LongFootprintKeepsWhatLiesAcrossIt) {
    // Stripes a texel wide along t. A footprint 8 texels long in t and one wide leaves them whole;
    // turned, it is their mean.
    std::vector<float> stripes(64 * 64);
    for (std::size_t i = 0; i < stripes.size(); ++i) stripes[i] = i % 2 ? 1.0f : 0.0f;
    const Texture texture = grey(64, stripes);
    const double one = 1.0 / 64, eight = 8.0 / 64;
    for (int x = 0; x < 8; ++x) {
        const V2d st((x + 0.5) / 64, 0.3);
        EXPECT_NEAR(value(texture, st, Wrap::Repeat, {one, 0}, {0, eight}), x % 2, 1e-9);
        EXPECT_NEAR(value(texture, st, Wrap::Repeat, {eight, 0}, {0, one}), 0.5, 1e-9);
    }
}

TEST(Filter, MagnifiedFootprintsAreBilinear) {
    const Texture texture = noise(16, 16);
    for (const double st : {0.1, 0.33, 0.77})
        EXPECT_EQ(value(texture, {st, st}, Wrap::Repeat, {1.0 / 16, 0}, {0, 0.9 / 16}),
                  value(texture, {st, st}, Wrap::Repeat));
}

TEST(Filter, OddFootprintsStayWithinTheImagesRange) {
    const Texture texture = noise(33, 20);
    const double huge = 1e200, tiny = 1e-300, nan = NAN, inf = INFINITY;
    for (const double a : {0.0, tiny, 1.0, huge, nan, inf})
        for (const double b : {0.0, tiny, -1.0, huge, nan, inf}) {
            const double found = value(texture, {0.2, 0.7}, Wrap::Mirror, {a, b}, {b, a});
            EXPECT_TRUE(found >= 0 && found <= 1) << a << ' ' << b;
        }
}

Tile constant(int u, int v, float level, int size = 4) {
    Tile out = tile(size, size, 1, TexelFormat::Float,
                    std::vector<float>(static_cast<std::size_t>(size * size), level));
    out.u = u;
    out.v = v;
    return out;
}

TEST(Udim, TilesAreFoundByStAndMissingOnesAreNone) {
    const Texture texture({constant(0, 0, 1), constant(2, 1, 3), constant(1, 0, 2, 16)},
                          Transfer::Linear, identity, true);
    const auto found = [&](double s, double t, double width = 0) {
        return look_up(texture, Wrap::Repeat, Wrap::Repeat, {s, t}, {width, 0}, {0, width});
    };
    EXPECT_EQ((*found(0.5, 0.5))[0], 1);
    EXPECT_EQ((*found(1.999, 0.001))[0], 2);
    EXPECT_EQ((*found(2.5, 1.5, 0.5))[0], 3);
    EXPECT_FALSE(found(0.5, 1.5));
    EXPECT_FALSE(found(-0.5, 0.5));
    EXPECT_EQ((*found(0.999, 0.5))[0], 1) << "tiles do not run into each other";
    const auto across = look_up(texture, Wrap::Repeat, Wrap::Repeat, {1, 0.5}, {1, 0}, {0, 0.25});
    EXPECT_DOUBLE_EQ((*across)[0], 1.5) << "but a footprint over both has both";
}

TEST(Texture, FinestLevelsMayGo) {
    const Texture texture = noise(64, 32);
    const std::vector<std::size_t> bytes = texture.level_bytes();
    EXPECT_EQ(bytes, (std::vector<std::size_t>{8192, 2048, 512, 128, 32, 8, 4}));
    const Texture less = texture.without_finest(2);
    EXPECT_EQ(less.level_bytes(), std::vector<std::size_t>(bytes.begin() + 2, bytes.end()));
    EXPECT_EQ(less.tiles()[0].levels[0].texels, texture.tiles()[0].levels[2].texels) << "shared";
    EXPECT_EQ(texture.without_finest(99).level_bytes(), std::vector<std::size_t>{4});
    EXPECT_DOUBLE_EQ(value(less, {0.4, 0.6}, Wrap::Repeat, {0.25, 0}, {0, 0.25}),
                     value(texture, {0.4, 0.6}, Wrap::Repeat, {0.25, 0}, {0, 0.25}));
    EXPECT_FALSE(same(texture, less));
}

TEST(Texture, SamenessIsOfBytes) {
    EXPECT_TRUE(same(grey(2, {0, 1, 2, 5}), grey(2, {0, 1, 2, 5})));
    EXPECT_FALSE(same(grey(2, {0, 1, 2, 5}), grey(2, {0, 1, 2, 4})));
    EXPECT_FALSE(same(grey(2, {0, 1, 2, 5}), grey(2, {-0.0f, 1, 2, 5})));
    const Tile t = constant(0, 0, 1);
    EXPECT_FALSE(same(Texture({t}, Transfer::Linear, identity, false),
                      Texture({t}, Transfer::Srgb, identity, false)));
    EXPECT_FALSE(same(Texture({t}, Transfer::Linear, identity, false),
                      Texture({t}, Transfer::Linear, {1, 0, 0, 0, 1, 0, 0, 0, 2}, false)));
}

TEST(Texture, WhatIsNoTextureIsRefused) {
    const auto make = [](std::vector<Tile> tiles, bool udim) {
        return Texture(std::move(tiles), Transfer::Linear, identity, udim);
    };
    EXPECT_THROW(make({}, false), std::invalid_argument);
    EXPECT_THROW(make({constant(0, 0, 1), constant(1, 0, 1)}, false), std::invalid_argument);
    EXPECT_THROW(make({constant(1, 0, 1), constant(1, 0, 1)}, true), std::invalid_argument);
    Tile empty = constant(0, 0, 1);
    empty.levels[0].width = 0;
    EXPECT_THROW(make({empty}, false), std::invalid_argument);
    Tile many = constant(0, 0, 1);
    many.channels = 5;
    EXPECT_THROW(make({many}, false), std::invalid_argument);
}

}  // namespace
}  // namespace irt::texture
