// SPDX-License-Identifier: Apache-2.0
// What a picture says of the object: by its alpha, or because it was drawn to be a mask.
#include <gtest/gtest.h>

#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "common/image/webp.h"
#include "support/expect_error.h"
#include "support/raw_png.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

/// "#" object, "." not; a row per text.
std::string drawn(const ImageU8& mask) {
  std::string rows;
  for (int y = 0; y < mask.height(); ++y, rows += '\n')
    for (int x = 0; x < mask.width(); ++x) rows += mask.at(x, y) == 255 ? '#' : mask.at(x, y) == 0 ? '.' : '?';
  return rows;
}

class MaskFile : public ::testing::Test {
 protected:
  std::string read(const std::string& bytes) const { return drawn(read_mask(folder_.write("mask", bytes))); }
  std::string of_image(const std::string& bytes) const {
    return drawn(read_masked_image(folder_.write("image", bytes)).mask);
  }
  const TempFolder folder_;
};

const std::string kPalette("\0\0\0\x80\0\0\0\x80\0\0\0\x80", 12);  // black, red, green, blue

TEST_F(MaskFile, AnyNumberOfAPaletteIsObject) {
  const std::string numbers("\0\1\2\3", 4);
  EXPECT_EQ(read(RawPng{4, 1, 8, 3, {{"PLTE", kPalette}}, numbers, {}}.bytes()), ".###\n");
  EXPECT_EQ(read(RawPng{4, 1, 2, 3, {{"PLTE", kPalette}}, "\x1b", {}}.bytes()), ".###\n") << "2 bits a pixel";
  EXPECT_EQ(read(RawPng{4, 1, 8, 3, {{"PLTE", std::string(12, '\0')}}, numbers, {}}.bytes()), ".###\n")
      << "all entries black";
  EXPECT_EQ(read(RawPng{4, 1, 8, 3, {{"PLTE", std::string(12, '\x77')}}, numbers, {}}.bytes()), ".###\n")
      << "no entry black";
  const std::string white_first("\xff\xff\xff\0\0\0", 6);
  EXPECT_EQ(read(RawPng{2, 1, 8, 3, {{"PLTE", white_first}}, std::string("\0\1", 2), {}}.bytes()), "#.\n")
      << "black and white in the order that a packer chose";
  EXPECT_EQ(read(RawPng{2, 1, 1, 3, {{"PLTE", white_first}}, "\x40", {}}.bytes()), "#.\n");
  const std::string clear_white("\xff\xff\xff\x10\x10\x10", 6);
  EXPECT_EQ(read(RawPng{2, 1, 8, 3, {{"PLTE", clear_white}, {"tRNS", std::string(1, '\0')}}, std::string("\0\1", 2), {}}
                     .bytes()),
            ".#\n")
      << "what is transparent is no object";
}

TEST_F(MaskFile, GreysAndNumbersOfAnyDepth) {
  EXPECT_EQ(read(RawPng{3, 1, 8, 0, {}, std::string("\0\1\xff", 3), {}}.bytes()), ".##\n");
  EXPECT_EQ(read(RawPng{3, 1, 16, 0, {}, std::string("\0\0\0\2\xff\xff", 6), {}}.bytes()), ".##\n");
  EXPECT_EQ(read(RawPng{8, 1, 1, 0, {}, "\x2d", {}}.bytes()), "..#.##.#\n");
  EXPECT_EQ(read(RawPng{2, 1, 8, 2, {}, std::string("\0\0\0\0\x80\0", 6), {}}.bytes()), ".#\n") << "a green object";
}

TEST_F(MaskFile, AlphaIsTheMaskWhereItSaysSomething) {
  const std::string red_then_clear("\xff\0\0\xff\xff\0\0\x7f", 8), black_then_clear("\0\0\0\xff\0\0\0\0", 8);
  EXPECT_EQ(read(RawPng{2, 1, 8, 6, {}, red_then_clear, {}}.bytes()), "#.\n");
  EXPECT_EQ(read(RawPng{2, 1, 8, 6, {}, black_then_clear, {}}.bytes()), "#.\n") << "a black shape on nothing";
  EXPECT_EQ(read(RawPng{2, 1, 8, 6, {}, std::string("\0\0\0\xff\xff\xff\xff\xff", 8), {}}.bytes()), ".#\n")
      << "opaque everywhere: the colours say it";
  EXPECT_EQ(read(RawPng{2, 1, 16, 4, {}, std::string("\0\1\xff\xff\0\1\0\0", 8), {}}.bytes()), "#.\n") << "16 bits";
}

TEST_F(MaskFile, JpegAndLossyWebPAreCutAtHalf) {
  ImageU8 disc(64, 64, 1), number(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool inside = (x - 31) * (x - 31) + (y - 30) * (y - 30) < 400;
      disc.at(x, y) = inside ? 255 : 0;
      number.at(x, y) = inside ? 40 : 0;
    }
  const auto wrong = [&](const std::string& bytes) {
    const ImageU8 mask = read_mask(folder_.write("mask", bytes));
    int pixels = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) pixels += mask.data()[i] != disc.data()[i];
    return pixels;
  };
  for (const ImageU8* image : {&disc, &number}) {
    const auto jpeg = encode_jpeg(*image, 80);
    EXPECT_LT(wrong({jpeg.begin(), jpeg.end()}), 20) << "of 1250 on the object, and about 200 next to its edge";
  }
  ImageU8 colour(64, 64, 3);
  for (std::size_t i = 0; i < disc.size(); ++i) std::fill_n(colour.data() + 3 * i, 3, disc.data()[i]);
  EXPECT_LT(wrong(encode_webp(colour, 40)), 20);
  EXPECT_EQ(wrong(encode_webp_lossless(colour)), 0);
  const auto nothing = encode_jpeg(ImageU8(16, 16, 1), 50);
  EXPECT_EQ(drawn(read_mask(folder_.write("nothing", std::string(nothing.begin(), nothing.end())))).find('#'),
            std::string::npos);
}

TEST_F(MaskFile, FloatsAreNoMask) {
  write_exr(folder_.path() / "a.exr", ImageF(2, 1, 1));
  expect_error([&] { read_mask(folder_.path() / "a.exr"); }, {"a.exr", "8-bit"});
}

TEST_F(MaskFile, AnImageSaysByItsAlphaWhatIsObject) {
  const std::string three("\1\2\3\xff\4\5\6\x80\7\x8\x9\x7f", 12);
  EXPECT_EQ(of_image(RawPng{3, 1, 8, 6, {}, three, {}}.bytes()), "##.\n");
  EXPECT_EQ(of_image(RawPng{2, 1, 8, 6, {}, std::string("\1\2\3\xff\4\5\6\xf0", 8), {}}.bytes()), "")
      << "it covers all: nothing is said";
  EXPECT_EQ(of_image(RawPng{2, 1, 8, 4, {}, std::string("\1\xff\2\0", 4), {}}.bytes()), "#.\n") << "grey";
  EXPECT_EQ(
      of_image(
          RawPng{2, 1, 8, 3, {{"PLTE", kPalette}, {"tRNS", std::string(1, '\0')}}, std::string("\0\1", 2), {}}.bytes()),
      ".#\n");
  EXPECT_EQ(of_image(RawPng{2, 1, 8, 2, {}, std::string(6, '\0'), {}}.bytes()), "");
}

}  // namespace
}  // namespace sheen
