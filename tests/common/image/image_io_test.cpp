// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "common/base/files.h"
#include "common/image/exr.h"
#include "common/image/webp.h"
#include "support/expect_error.h"
#include "support/raw_png.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

ImageU8 noise(int width, int height, int channels) {
  std::mt19937 random(3);
  ImageU8 image(width, height, channels);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<std::uint8_t>(random());
  return image;
}

/// Slow waves, which JPEG keeps well.
ImageU8 waves(int width, int height, int channels) {
  ImageU8 image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        image.at(x, y, c) = static_cast<std::uint8_t>(128 + 90 * std::sin(0.1 * x + c) * std::cos(0.07 * y));
  return image;
}

std::string text_of(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST(Png, GreyAndColourComeBackBitForBit) {
  const TempFolder folder;
  for (const int channels : {1, 3}) {
    const ImageU8 image = noise(33, 21, channels);
    write_png(folder.path() / "a.png", image);
    const RawImage raw = read_image(folder.path() / "a.png");
    EXPECT_EQ(raw.format, channels == 1 ? PixelFormat::kMono8 : PixelFormat::kRGB8);
    EXPECT_EQ(raw.transfer, Transfer::kSrgb);
    EXPECT_EQ(validation_error(raw), "");
    EXPECT_TRUE(std::equal(raw.bytes.begin(), raw.bytes.end(), image.data(), image.data() + image.size()));
    const ImageSize size = read_image_size(folder.path() / "a.png");
    EXPECT_EQ(size.width, 33);
    EXPECT_EQ(size.height, 21);
  }
}

TEST(Png, AlphaIsDroppedNotBlended) {
  const TempFolder folder;
  const std::string pixels("\x10\x20\x30\0\x40\x50\x60\xff", 8);  // the first is transparent
  const RawImage raw = read_image(folder.write("a.png", RawPng{2, 1, 8, 6, {}, pixels, {}}.bytes()));
  EXPECT_EQ(raw.format, PixelFormat::kRGB8);
  EXPECT_EQ(raw.bytes, (std::vector<std::uint8_t>{0x10, 0x20, 0x30, 0x40, 0x50, 0x60}));
}

TEST(Png, OfSixteenBitsTheUpperEightAsTheyAreCoded) {
  const TempFolder folder;
  const std::string pixels("\x10\0\x20\x20\xff\xff\x40\0", 8);  // two of grey and alpha
  const MaskedImage grey = read_masked_image(folder.write("a.png", RawPng{2, 1, 16, 4, {}, pixels, {}}.bytes()));
  EXPECT_EQ(grey.image.bytes, (std::vector<std::uint8_t>{0x10, 0xff}));
  EXPECT_EQ(grey.mask, ImageU8(2, 1, 1)) << "covered by a tenth and a quarter";
  const std::string colours("\x10\0\x20\0\x30\0", 6);
  const RawImage rgb = read_image(folder.write("b.png", RawPng{1, 1, 16, 2, {}, colours, {}}.bytes()));
  EXPECT_EQ(rgb.bytes, (std::vector<std::uint8_t>{0x10, 0x20, 0x30}));
  EXPECT_EQ(rgb.transfer, Transfer::kSrgb);
}

TEST(Png, ClaimedSizeIsNotBelieved) {
  const TempFolder folder;
  const RawPng absurd{900000, 900000, 8, 2, {}, {}, {}};
  std::string bytes = RawPng{2, 1, 8, 2, {}, std::string(6, '\0'), {}}.bytes();
  const std::string head = absurd.header();
  bytes.replace(0, head.size(), head);
  expect_error([&] { read_image(folder.write("b.png", bytes)); },
               {"b.png", "900000 x 900000", "more than the file can hold"});
}

TEST(Png, ColoursAreWrittenBesideAlphaAsTheyAre) {
  const TempFolder folder;
  const auto path = folder.path() / "a.png";
  const ImageU8 image = noise(7, 5, 4);
  write_png(path, image);
  const std::string bytes = read_file(path);
  constexpr std::size_t kColourType = 25;  // of IHDR: 8 bytes of signature, 8 of the chunk, width, height, depth
  EXPECT_EQ(bytes.at(kColourType), 6) << "RGB and alpha";
  const RawImage read = read_image(path);
  for (int i = 0; i < 7 * 5; ++i)
    for (int c = 0; c < 3; ++c) ASSERT_EQ(read.bytes[3 * i + c], image.data()[4 * i + c]) << "also where alpha is low";
}

TEST(Jpeg, KeepsAPictureWithinItsQuality) {
  const TempFolder folder;
  for (const int channels : {1, 3}) {
    const ImageU8 image = waves(65, 43, channels);
    const auto file = folder.write("a.jpg", text_of(encode_jpeg(image, 95)));
    const RawImage raw = read_image(file);
    EXPECT_EQ(raw.format, channels == 1 ? PixelFormat::kMono8 : PixelFormat::kRGB8);
    ASSERT_EQ(raw.bytes.size(), image.size());
    double squares = 0;
    for (std::size_t i = 0; i < image.size(); ++i) squares += std::pow(double(raw.bytes[i]) - image.data()[i], 2);
    EXPECT_LT(std::sqrt(squares / double(image.size())), 3);
    EXPECT_EQ(read_image_size(file).width, 65);
  }
  EXPECT_GT(encode_jpeg(waves(64, 64, 3), 95).size(), encode_jpeg(waves(64, 64, 3), 30).size());
  EXPECT_THROW(encode_jpeg({}, 90), Error);
  EXPECT_THROW(encode_jpeg(ImageU8(4, 4, 2), 90), Error);
  EXPECT_THROW(encode_jpeg(ImageU8(4, 4, 3), 0), Error);
}

TEST(Jpeg, CutOffIsAnErrorNotGreyPixels) {
  const TempFolder folder;
  const std::string whole = text_of(encode_jpeg(noise(64, 64, 3), 90));
  for (std::size_t size = 0; size + 40 < whole.size(); size += 53)
    EXPECT_THROW(read_image(folder.write("a.jpg", whole.substr(0, size))), FileError) << size;
  expect_error([&] { read_image(folder.write("a.jpg", whole.substr(0, whole.size() / 2))); },
               {"a.jpg", "damaged JPEG"});
}

TEST(Jpeg, ClaimedSizeIsNotBelieved) {
  const TempFolder folder;
  std::string bytes = text_of(encode_jpeg(waves(16, 16, 3), 90));
  const std::size_t frame = bytes.find(std::string("\xff\xc0", 2));
  ASSERT_NE(frame, std::string::npos);
  bytes.replace(frame + 5, 4, std::string("\xf0\0\xf0\0", 4));
  expect_error([&] { read_image(folder.write("a.jpg", bytes)); }, {"a.jpg", "61440 x 61440"});
}

TEST(WebP, KeepsAPictureWithinItsQualityOrExactly) {
  const TempFolder folder;
  const ImageU8 image = waves(65, 43, 3);
  const auto lossy = folder.write("a.webp", encode_webp(image, 95)),
             exact = folder.write("b.webp", encode_webp_lossless(image));
  const RawImage raw = read_image(lossy);
  EXPECT_EQ(raw.format, PixelFormat::kRGB8);
  EXPECT_EQ(raw.transfer, Transfer::kSrgb);
  ASSERT_EQ(raw.bytes.size(), image.size());
  double squares = 0;
  for (std::size_t i = 0; i < image.size(); ++i) squares += std::pow(double(raw.bytes[i]) - image.data()[i], 2);
  EXPECT_LT(std::sqrt(squares / double(image.size())), 4);
  EXPECT_TRUE(std::equal(image.data(), image.data() + image.size(), read_image(exact).bytes.begin()));
  EXPECT_EQ(read_image_size(lossy).width, 65);
  EXPECT_EQ(read_image_size(exact).height, 43);
  EXPECT_THROW(encode_webp(ImageU8(4, 4, 1), 90), Error);
}

TEST(WebP, ClaimedSizeIsNotBelieved) {
  const TempFolder folder;
  std::string bytes = encode_webp(waves(16, 16, 3), 90);
  const std::size_t start = bytes.find(std::string("\x9d\x01\x2a", 3));
  ASSERT_NE(start, std::string::npos);
  bytes.replace(start + 3, 4, std::string("\xff\x3f\xff\x3f", 4));
  expect_error([&] { read_image(folder.write("a.webp", bytes)); }, {"a.webp", "16383 x 16383"});
  expect_error([&] { read_image_size(folder.write("a.webp", bytes)); }, {"a.webp", "16383 x 16383"});
  expect_error([&] { read_image(folder.write("a.webp", bytes.substr(0, 20))); }, {"a.webp", "damaged WebP"});
}

TEST(ImageFiles, DamagedBytesAreReadOrRefused) {
  const TempFolder folder;
  write_png(folder.path() / "a.png", waves(40, 30, 3));
  for (const std::string& whole : {read_file(folder.path() / "a.png"), text_of(encode_jpeg(waves(40, 30, 3), 80)),
                                   encode_webp(waves(40, 30, 3), 80), encode_webp_lossless(waves(40, 30, 3))})
    for (std::size_t i = 0; i < whole.size(); i += 3) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ 0xa5);
      try {
        const RawImage image = read_image(folder.write("damaged", damaged));
        EXPECT_EQ(validation_error(image), "") << i;
      } catch (const FileError&) {
        continue;
      }
    }
}

TEST(ImageFiles, MissingEmptyAndUnknown) {
  const TempFolder folder;
  expect_error([&] { read_image(folder.path() / "none.png"); }, {"none.png", "no such file"});
  expect_error([&] { read_image(folder.write("empty.png", "")); }, {"empty.png", "is empty"});
  expect_error([&] { read_image(folder.write("text.png", "hello")); },
               {"text.png", "neither JPEG nor PNG nor WebP nor EXR"});
  expect_error([&] { read_image(folder.path()); }, {"regular file"});
  expect_error([&] { write_png("/dev/full/a.png", waves(4, 4, 1)); }, {"a.png", "cannot be written"});
  expect_error([&] { write_png(folder.path() / "a.png", ImageU8(4, 4, 2)); }, {"a.png", "1, 3 or 4 channels"});
}

TEST(ExrImages, LinearFloats) {
  const TempFolder folder;
  ImageF image(3, 2, 3);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = 0.37f * float(i) - 1;
  write_exr(folder.path() / "a.exr", image);
  const RawImage raw = read_image(folder.path() / "a.exr");
  EXPECT_EQ(raw.format, PixelFormat::kRGB32f);
  EXPECT_EQ(raw.transfer, Transfer::kLinear);
  EXPECT_EQ(validation_error(raw), "");
  EXPECT_EQ(std::memcmp(raw.bytes.data(), image.data(), raw.bytes.size()), 0);

  ImageF grey(2, 1, 1);
  grey.at(1, 0) = 0.25f;
  write_exr(folder.path() / "grey.exr", grey);
  const RawImage from_grey = read_image(folder.path() / "grey.exr");
  float values[6];
  ASSERT_EQ(from_grey.bytes.size(), sizeof values);
  std::memcpy(values, from_grey.bytes.data(), sizeof values);
  EXPECT_EQ(values[2], 0);
  EXPECT_EQ(values[3], 0.25f);
  EXPECT_EQ(values[5], 0.25f);
}

TEST(ExrImages, RefusesWhatIsNoPicture) {
  const TempFolder folder;
  ExrFile file;
  file.parts.push_back({"normals", {"X", "Y", "Z"}, ImageF(2, 2, 3)});
  write_exr(folder.path() / "xyz.exr", file);
  expect_error([&] { read_image(folder.path() / "xyz.exr"); }, {"xyz.exr", "R, G, B"});
}

}  // namespace
}  // namespace sheen
