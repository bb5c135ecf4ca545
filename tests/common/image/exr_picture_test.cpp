// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/base/files.h"
#include "common/image/exr.h"
#include "common/image/exr_environment.h"
#include "support/expect_error.h"
#include "support/shared_data.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

/// Every pixel of channel c is c + 1.
ImageF numbered(int width, int height, int channels) {
  ImageF image(width, height, channels);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = float(i % std::size_t(channels)) + 1;
  return image;
}

ExrPart part(const std::string& name, const std::vector<std::string>& channels) {
  return {name, channels, numbered(2, 2, int(channels.size()))};
}

class ExrPictures : public ::testing::Test {
 protected:
  std::filesystem::path write(std::vector<ExrPart> parts) const {
    write_exr(folder_.path() / "a.exr", ExrFile{std::move(parts), {}});
    return folder_.path() / "a.exr";
  }
  /// Red, green and blue of the first pixel.
  std::vector<float> first(std::vector<ExrPart> parts) const {
    return pixel(read_exr_picture(write(std::move(parts))).image, 0, 0);
  }
  static std::vector<float> pixel(const RawImage& image, int x, int y) {
    std::vector<float> rgb(3);
    std::memcpy(rgb.data(), image.bytes.data() + std::size_t(y) * image.stride + std::size_t(x) * 12, 12);
    return rgb;
  }
  void refused(std::vector<ExrPart> parts, std::vector<std::string> words) const {
    const auto path = write(std::move(parts));
    words.push_back("a.exr");
    expect_error([&] { read_exr_picture(path); }, words);
    expect_error([&] { read_exr_picture_size(path); }, words);
  }
  const TempFolder folder_;
};

using Rgb = std::vector<float>;

TEST_F(ExrPictures, TheLayerThatIsThePictureByItsName) {
  EXPECT_EQ(first({part("main", {"ViewLayer.AO.R", "ViewLayer.AO.G", "ViewLayer.AO.B", "ViewLayer.Combined.R",
                                 "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Depth.Z"})}),
            (Rgb{4, 5, 6}));
  EXPECT_EQ(first({part("main", {"beauty.R", "beauty.G", "beauty.B", "N.R", "N.G", "N.B"})}), (Rgb{1, 2, 3}));
  EXPECT_EQ(first({part("main", {"AO.R", "AO.G", "AO.B", "R", "G", "B"})}), (Rgb{4, 5, 6})) << "without a layer";
  EXPECT_EQ(first({part("main", {"Composite.Combined.R", "Composite.Combined.G", "Composite.Combined.B", "V.Combined.R",
                                 "V.Combined.G", "V.Combined.B"})}),
            (Rgb{1, 2, 3}))
      << "what Blender composed of its layers";
  EXPECT_EQ(first({part("V.AO", {"R", "G", "B"}), part("V.Combined", {"X", "R", "G", "B"})}), (Rgb{2, 3, 4}))
      << "layers as parts";
  EXPECT_EQ(first({part("main", {"left.R", "left.G", "left.B"})}), (Rgb{1, 2, 3})) << "the only one there is";
  EXPECT_EQ(first({part("main", {"Y", "Z"})}), (Rgb{1, 1, 1})) << "grey beside depth";
}

TEST_F(ExrPictures, WhatLeavesItOpenIsRefusedWithItsLayers) {
  refused({part("main", {"AO.R", "AO.G", "AO.B", "Depth.Z"})},
          {"none of its layers is a picture", "AO (R G B)", "Depth (Z)"});
  refused({part("main", {"a.rgba.R", "a.rgba.G", "a.rgba.B", "b.rgba.R", "b.rgba.G", "b.rgba.B"})},
          {"more than one", "a.rgba (R G B)", "b.rgba (R G B)"});
  refused({part("AO", {"R", "G", "B"}), part("N", {"R", "G", "B"})}, {"AO (R G B), N (R G B)"});
  refused({part("main", {"X", "Y", "Z"})}, {"R, G, B"});
  refused({part("main", {"Z"})}, {"(no layer) (Z)"});
}

TEST_F(ExrPictures, AreOfTheSizeOfTheirDisplayWindow) {
  ExrPart data = part("main", {"R", "G", "B"});
  data.left = 1;
  data.picture = {4, 3};
  const auto path = write({data});
  EXPECT_EQ(read_exr_picture_size(path).width, 4);
  MaskedImage masked = read_exr_picture(path);
  EXPECT_EQ(masked.image.height, 3);
  EXPECT_EQ(pixel(masked.image, 1, 0), (Rgb{1, 2, 3}));
  EXPECT_EQ(pixel(masked.image, 0, 0), (Rgb{0, 0, 0}));
  EXPECT_EQ(masked.mask.at(0, 0), 0) << "nothing is known of it";
  EXPECT_EQ(masked.mask.at(2, 1), 255);
  EXPECT_EQ(masked.mask.at(3, 1), 0);
  EXPECT_EQ(masked.mask.at(1, 2), 0);
  data.left = -1;  // overscan
  data.picture = {1, 1};
  masked = read_exr_picture(write({data}));
  EXPECT_EQ(masked.image.width, 1);
  EXPECT_TRUE(masked.mask.empty());
}

TEST_F(ExrPictures, AlphaIsTheMaskAndIsTakenOutOfTheColours) {
  ImageF image(3, 1, 4);
  const float values[] = {0.5f, 1, 2, 1, 0.25f, 0.5f, 1, 0.5f, 0.1f, 0.1f, 0.1f, 0.2f};
  std::copy(std::begin(values), std::end(values), image.data());
  const MaskedImage masked = read_exr_picture(write({{"main", {"R", "G", "B", "A"}, image}}));
  EXPECT_EQ(pixel(masked.image, 0, 0), (Rgb{0.5f, 1, 2}));
  EXPECT_EQ(pixel(masked.image, 1, 0), (Rgb{0.5f, 1, 2}));
  EXPECT_EQ(masked.mask.at(1, 0), 255);
  EXPECT_EQ(masked.mask.at(2, 0), 0);
}

/// A face is bright where the axis is that it is of.
/// By ITU-R BT.2087: linear BT.2020 to BT.709, of one white.
TEST_F(ExrPictures, ColoursOfOtherPrimariesBecomeThoseOfSrgb) {
  const std::string bt2020 = "0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290",
                    aces = "0.7347 0.2653 0 1 0.0001 -0.077 0.32168 0.33767",
                    srgb = "0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329";
  const auto read = [&](const std::string& chromaticities, const std::vector<float>& rgb) {
    ExrFile file{{part("main", {"R", "G", "B"})}, {{"chromaticities", chromaticities}}};
    for (std::size_t i = 0; i < file.parts[0].image.size(); ++i) file.parts[0].image.data()[i] = rgb[i % 3];
    write_exr(folder_.path() / "a.exr", file);
    return pixel(read_exr_picture(folder_.path() / "a.exr").image, 1, 1);
  };
  const Rgb green = read(bt2020, {0.3f, 0.5f, 0.4f});
  EXPECT_NEAR(green[0], 1.6605f * 0.3f - 0.5876f * 0.5f - 0.0728f * 0.4f, 1e-3);
  EXPECT_NEAR(green[1], -0.1246f * 0.3f + 1.1329f * 0.5f - 0.0083f * 0.4f, 1e-3);
  EXPECT_NEAR(green[2], -0.0182f * 0.3f - 0.1006f * 0.5f + 1.1187f * 0.4f, 1e-3);
  EXPECT_EQ(read(bt2020, {0, 1, 0})[0], 0) << "outside of sRGB's gamut";
  for (const float value : read(bt2020, {2, 2, 2})) EXPECT_NEAR(value, 2, 1e-5) << "white stays white";
  for (const float value : read(aces, {1, 1, 1})) EXPECT_NEAR(value, 1, 1e-4) << "of another white, too";
  EXPECT_EQ(read(srgb, {1, 2, 3}), (Rgb{1, 2, 3}));
  expect_error([&] { read("0.3 0.3 0.3 0.3 0.3 0.3 0.3 0.3", {1, 1, 1}); }, {"a.exr", "chromaticities"});
}

TEST(ExrEnvironment, CubeFacesBecomeLatitudeAndLongitude) {
  constexpr int kSide = 16;
  ImageF cube(kSide, 6 * kSide, 3);
  for (int y = 0; y < cube.height(); ++y)
    for (int x = 0; x < kSide; ++x) cube.at(x, y, 0) = float(y / kSide) + 1;  // +x, -x, +y, -y, +z, -z
  const TempFolder folder;
  write_exr(folder.path() / "cube.exr", ExrFile{{{"map", {"R", "G", "B"}, cube}}, {{"envmap", "cube"}}});
  const ImageF map = read_exr_environment(folder.path() / "cube.exr");
  ASSERT_EQ(map.width(), 4 * kSide);
  ASSERT_EQ(map.height(), 2 * kSide);
  // As OpenEXR has it: up is y, the middle is +z, and a quarter to the left of it +x.
  const auto at = [&](double longitude, double latitude) {
    return map.at(int((0.5 - longitude / 360) * (map.width() - 1)), int((0.5 - latitude / 180) * (map.height() - 1)),
                  0);
  };
  EXPECT_EQ(at(90, 0), 1);
  EXPECT_EQ(at(-90, 0), 2);
  EXPECT_EQ(at(0, 89), 3);
  EXPECT_EQ(at(0, -89), 4);
  EXPECT_EQ(at(0, 0), 5);
  EXPECT_EQ(at(179, 0), 6);
}

TEST(ExrEnvironment, WhatIsNoMapOfAllAroundIsRefused) {
  const TempFolder folder;
  const auto refused = [&](int width, int height, const ExrAttributes& attributes, const std::string& words) {
    write_exr(folder.path() / "a.exr", ExrFile{{{"map", {"R", "G", "B"}, ImageF(width, height, 3)}}, attributes});
    expect_error([&] { read_exr_environment(folder.path() / "a.exr"); }, {"a.exr", words});
  };
  refused(8, 8, {}, "twice as wide as high");
  refused(4, 24, {}, "attribute envmap");
  refused(4, 16, {{"envmap", "cube"}}, "six square faces");
  write_exr(folder.path() / "a.exr", ExrFile{{{"map", {"R", "G", "B"}, ImageF(8, 4, 3)}}, {{"envmap", "latlong"}}});
  EXPECT_EQ(read_exr_environment(folder.path() / "a.exr").width(), 8);
}

// The same light as both kinds of map, made by others.
TEST(ExrEnvironment, OpenExrsOwnMapsAgree) {
  const auto folder = shared_data("field") / "40-environment-cube-faces";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data";
  const ImageF made = read_exr_environment(folder / "WavyLinesCube.exr"),
               given = read_exr_environment(folder / "WavyLinesLatLong.exr");
  ASSERT_EQ(made.width(), given.width());
  // Their lines are about a pixel wide: means of blocks are compared.
  constexpr int kBlock = 16;
  double sum = 0, squares = 0;
  for (int top = 0; top < given.height(); top += kBlock)
    for (int left = 0; left < given.width(); left += kBlock) {
      double off = 0, light = 0;
      for (int y = top; y < top + kBlock; ++y)
        for (int x = left; x < left + kBlock; ++x) {
          off += made.at(x, y) - given.at(x, y);
          light += given.at(x, y);
        }
      sum += off * off;
      squares += light * light;
    }
  EXPECT_LT(sum, 0.01 * squares) << "but for what sampling leaves";
}

}  // namespace
}  // namespace sheen
