// SPDX-License-Identifier: Apache-2.0
#include "common/base/quantity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

TEST(Quantity, UnitsAreWhatTheySay) {
  EXPECT_DOUBLE_EQ(parse_time_ms("--budget", "33ms", "a time"), 33);
  EXPECT_DOUBLE_EQ(parse_time_ms("--budget", "0.2 s", "a time"), 200);
  EXPECT_DOUBLE_EQ(parse_decibels("--loss", "0dB", "a loss"), 0);
  EXPECT_DOUBLE_EQ(parse_length_m("--length", "25mm", "a length"), 0.025);
  EXPECT_DOUBLE_EQ(parse_length_m("--length", "2.5cm", "a length"), 0.025);
  EXPECT_DOUBLE_EQ(parse_bytes("--bytes", "2MB", "a size"), 2e6);
  EXPECT_DOUBLE_EQ(parse_bytes("--bytes", "2MiB", "a size"), 2097152);
  EXPECT_DOUBLE_EQ(parse_bytes("--bytes", "639000", "a size"), 639000);
  EXPECT_DOUBLE_EQ(parse_bytes("--memory", "5e8", "a size"), 5e8);
}

TEST(Quantity, WhatIsNoneIsRefusedWithTheNameOfTheOption) {
  for (const char* word : {"", "ms", "33", "-33ms", "0ms", "nanms", "infms", "1e999ms", "33 ms ", "33dB", "0x10ms"})
    expect_error<ConfigError>([&] { parse_time_ms("--budget", word, "a time"); }, {"--budget", "takes a time"});
  expect_error<ConfigError>([] { parse_length_m("--length", "11m", "a length"); }, {"--length", "10 m at most"});
}

TEST(Quantity, AnImageSizeIsWidthAndHeight) {
  EXPECT_THAT(parse_image_size("--size", "1280x800", 64), testing::ElementsAre(1280, 800));
  EXPECT_THAT(parse_image_size("--size", "64x16384", 64), testing::ElementsAre(64, 16384));
}

TEST(Quantity, AnImageSizeOfNoImageIsRefused) {
  for (const char* word : {"", "1280", "x800", "1280x", "1280x800x3", "1280x800 ", "1280*800", "63x64", "-64x64",
                           "64x16385", "99999999999x64", "1e3x1e3", "+64x64", " 64x64", "64 x64"})
    expect_error<ConfigError>([&] { parse_image_size("--size", word, 64); },
                              {"--size", "WIDTHxHEIGHT", "64..16384 pixels"});
}

TEST(Quantity, GigabytesHaveThreeDigits) {
  EXPECT_EQ(gigabytes(12.34e9), "12.3 GB");
  EXPECT_EQ(gigabytes(24e9), "24 GB");
}

}  // namespace
}  // namespace sheen
