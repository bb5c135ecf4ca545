// SPDX-License-Identifier: Apache-2.0
#include "common/image/exif.h"

#include <gtest/gtest.h>

#include <vector>

namespace sheen {
namespace {

/// EXIF data as the standard lays them out: a main folder with an orientation (turned by a quarter), which points to
/// the EXIF folder with three entries.
class Tiff {
 public:
  explicit Tiff(bool big_endian) : big_endian_(big_endian) {
    bytes_ = big_endian ? "MM" : "II";
    put(42, 2);
    put(8, 4);
    put(2, 2);  // main folder at 8: two entries
    put(0x0112, 2);
    put(3, 2);
    put(1, 4);
    put(6, 2);
    put(0, 2);
    entry(0x8769, 4, 38);
    put(0, 4);
    put(3, 2);  // EXIF folder at 38
    entry(0x829A, 5, 80);
    entry(0x829D, 5, 88);
    put(0x8827, 2);
    put(3, 2);
    put(1, 4);
    put(400, 2);
    put(0, 2);
    put(0, 4);
    put(1, 4);  // at 80: 1 / 250 s
    put(250, 4);
    put(28, 4);  // at 88: f / 2.8
    put(10, 4);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void put(std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes_.push_back(char(value >> 8 * (big_endian_ ? size - 1 - i : i)));
  }
  void entry(std::uint32_t tag, std::uint32_t type, std::uint32_t value) {
    put(tag, 2);
    put(type, 2);
    put(1, 4);
    put(value, 4);
  }
  bool big_endian_;
  std::string bytes_;
};

std::string jpeg_with(const std::string& tiff) {
  const std::string exif = std::string("Exif\0\0", 6) + tiff;
  const std::size_t length = exif.size() + 2;
  return std::string("\xff\xd8\xff\xe0\x00\x04zz", 8) + "\xff\xe1" + char(length >> 8) + char(length & 255) + exif +
         "\xff\xda";
}

std::string png_with(const std::string& tiff) {
  return std::string("\x89PNG\r\n\x1a\n\0\0\0\1sPLT!....", 21) + std::string("\0\0\0", 3) + char(tiff.size()) + "eXIf" +
         tiff + "....";
}

/// Behind the pixels, as WebP has it; their odd length is filled up.
std::string webp_with(const std::string& exif) {
  const auto size = [](std::size_t n) { return std::string{char(n), char(n >> 8), 0, 0}; };
  const std::string chunks = "WEBPVP8L" + size(3) + std::string("\1\2\3\0", 4) + "EXIF" + size(exif.size()) + exif;
  return "RIFF" + size(chunks.size()) + chunks;
}

TEST(Exif, ExposureOfBothByteOrdersAndContainers) {
  for (const bool big_endian : {false, true})
    for (const std::string& file :
         {jpeg_with(Tiff(big_endian).bytes()), png_with(Tiff(big_endian).bytes()), webp_with(Tiff(big_endian).bytes()),
          webp_with(std::string("Exif\0\0", 6) + Tiff(big_endian).bytes())}) {
      const auto exif = read_exif_exposure(file);
      ASSERT_TRUE(exif);
      EXPECT_DOUBLE_EQ(exif->exposure_s, 1.0 / 250);
      EXPECT_DOUBLE_EQ(exif->iso, 400);
      EXPECT_DOUBLE_EQ(exif->f_number, 2.8);
      EXPECT_EQ(read_exif_orientation(file), 6);
    }
}

TEST(Exif, NothingWhereThereIsNothing) {
  EXPECT_FALSE(read_exif_exposure(""));
  EXPECT_FALSE(read_exif_exposure("\xff\xd8"));
  EXPECT_FALSE(read_exif_exposure("\x89PNG"));
  EXPECT_FALSE(read_exif_exposure("neither"));
  EXPECT_FALSE(read_exif_exposure(jpeg_with("II*")));
  for (const std::string& file : {std::string(), jpeg_with("II*"), png_with("")})
    EXPECT_EQ(read_exif_orientation(file), 1);
}

TEST(Exif, CutOffOrDamagedIsNeverReadPastItsEnd) {
  const std::string whole = jpeg_with(Tiff(false).bytes()), in_png = png_with(Tiff(true).bytes()),
                    in_webp = webp_with(Tiff(true).bytes());
  for (const std::string& file : {whole, in_png, in_webp})
    for (std::size_t size = 0; size < file.size(); ++size) {
      const std::vector<char> exact(file.begin(), file.begin() + std::ptrdiff_t(size));  // a sanitizer sees its end
      read_exif_exposure({exact.data(), exact.size()});
      for (const unsigned char value : {0x00, 0x7f, 0xff}) {
        std::string damaged = file;
        damaged[size] = char(value);
        if (const auto exif = read_exif_exposure(damaged)) {
          EXPECT_GT(exif->exposure_s, 0);
        }
        const int orientation = read_exif_orientation(damaged);
        EXPECT_TRUE(orientation >= 1 && orientation <= 8) << orientation;
      }
    }
  EXPECT_FALSE(read_exif_exposure(whole.substr(0, whole.size() / 2)));
}

}  // namespace
}  // namespace sheen
