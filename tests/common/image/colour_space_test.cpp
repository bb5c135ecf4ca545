// SPDX-License-Identifier: Apache-2.0
#include "common/image/colour_space.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <cmath>

#include "tests/support/icc_profile.h"

namespace sheen {
namespace {

std::string png_with(const std::string& type, const std::string& content) {
  return "\x89PNG\r\n\x1a\n" + big_endian(content.size(), 4) + type + content + "....";
}

std::string png_with_profile(const std::string& profile) {
  std::string packed(compressBound(profile.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(profile.data()),
           profile.size());
  return png_with("iCCP", std::string("any name\0\0", 10) + packed.substr(0, size));
}

std::string webp_with_profile(const std::string& profile) {
  const auto size = [](std::size_t n) { return std::string{char(n), char(n >> 8), 0, 0}; };
  const std::string chunks = "WEBPICCP" + size(profile.size()) + profile;
  return "RIFF" + size(chunks.size()) + chunks;
}

std::array<std::string, 3> files_with(const std::string& profile) {
  return {"\xff\xd8" + jpeg_profile(profile) + "\xff\xda", png_with_profile(profile), webp_with_profile(profile)};
}

TEST(ColourSpace, OfOtherPrimariesIsNamed) {
  for (const std::string& file : files_with(icc_profile("Display P3", kDisplayP3, parametric_srgb())))
    EXPECT_EQ(other_colour_space(file), "Display P3");
  for (const std::string& file : files_with(icc_profile("Adobe RGB (1998)", kAdobeRgb, power_curve(2.2))))
    EXPECT_EQ(other_colour_space(file), "Adobe RGB (1998)");
}

TEST(ColourSpace, OfSrgbByItsNumbersWhateverItsNameIsNone) {
  for (const std::string& curve : {parametric_srgb(), power_curve(2.2), sampled_srgb(1024)})
    for (const std::string& file : files_with(icc_profile("a monitor", kSrgb, curve)))
      EXPECT_EQ(other_colour_space(file), "");
}

TEST(ColourSpace, OfOtherCurvesIsNamed) {
  const std::string linear = "curv" + big_endian(0, 4) + big_endian(0, 4);
  for (const std::string& curve : {linear, power_curve(1.8)})
    for (const std::string& file : files_with(icc_profile("sRGB it says", kSrgb, curve)))
      EXPECT_EQ(other_colour_space(file), "sRGB it says");
}

TEST(ColourSpace, OfPngChunks) {
  const auto chromaticities = [](const std::array<std::size_t, 8>& values) {
    std::string content;
    for (const std::size_t value : values) content += big_endian(value, 4);
    return png_with("cHRM", content);
  };
  EXPECT_EQ(other_colour_space(chromaticities({31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000})), "");
  EXPECT_NE(other_colour_space(chromaticities({31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000})), "");
  EXPECT_EQ(other_colour_space(png_with("gAMA", big_endian(45455, 4))), "");
  EXPECT_NE(other_colour_space(png_with("gAMA", big_endian(100000, 4))), "") << "linear light";
}

TEST(ColourSpace, OfFilesThatSayNothingOrAreCutShortIsNone) {
  EXPECT_EQ(other_colour_space(""), "");
  EXPECT_EQ(other_colour_space("GIF89a"), "");
  for (const std::string& whole : files_with(icc_profile("Display P3", kDisplayP3, parametric_srgb())))
    for (std::size_t length = 0; length < whole.size(); ++length) {
      const std::string cut = whole.substr(0, length);
      const std::string space = other_colour_space(cut);  // of part of a profile anything may be said
      EXPECT_LE(space.size(), 60u);
    }
}

}  // namespace
}  // namespace sheen
