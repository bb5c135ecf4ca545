// SPDX-License-Identifier: Apache-2.0
// Whatever a JPEG or PNG file holds: pixels of the size that its header says, the same each time, or a FileError. What
// its EXIF data say of the exposure makes sense, and is the same in either byte order and either kind of file.
#include <cmath>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/exif.h"
#include "common/image/image_io.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace sheen;
using fuzz::demand;
using fuzz::Input;

const TempFolder& folder() {
  static const TempFolder folder;
  return folder;
}

ImageU8 ramp(int channels) {
  ImageU8 image(11, 9, channels);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<std::uint8_t>(7 * i);
  return image;
}

std::string jpeg_of(const ImageU8& image) {
  const std::vector<std::uint8_t> bytes = encode_jpeg(image, 80);
  return {bytes.begin(), bytes.end()};
}

std::string png_of(const ImageU8& image) {
  write_png(folder().path() / "valid.png", image);
  return read_file(folder().path() / "valid.png");
}

void expect_sensible(const std::optional<ExifExposure>& exposure) {
  if (!exposure) return;
  demand(std::isfinite(exposure->exposure_s) && exposure->exposure_s > 0, "an exposure time without sense");
  demand(std::isfinite(exposure->iso) && exposure->iso >= 0, "an ISO number without sense");
  demand(std::isfinite(exposure->f_number) && exposure->f_number >= 0, "an f-number without sense");
}

void expect_sound(const std::string& bytes) {
  expect_sensible(read_exif_exposure(bytes));
  const auto file = folder().write("input", bytes);
  const ImageSize size = read_image_size(file);
  const RawImage image = read_image(file);
  demand(validation_error(image).empty(), "an unsound image");
  demand(size.width == image.width && size.height == image.height, "another size than the header says");
  demand(image == read_image(file), "other pixels the second time");
  read_mask(file);
}

void arbitrary_file(Input in) {
  expect_sound((in.byte() % 2 ? "\xFF\xD8\xFF" : "\x89PNG\r\n\x1A\n") + in.text());
}

void damaged_file(Input in) {
  static const std::string kValid[] = {jpeg_of(ramp(1)), jpeg_of(ramp(3)), png_of(ramp(1)), png_of(ramp(3))};
  std::string bytes = kValid[in.byte() % std::size(kValid)];
  while (in.rest.size() >= 4) fuzz::damage_once(bytes, in);
  expect_sound(bytes);
}

void append(std::string& bytes, std::uint32_t value, int size, bool big_endian) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> 8 * (big_endian ? size - 1 - i : i));
}

/// Two folders and a table of rational numbers, which only they refer to: where one pointed elsewhere, the byte orders
/// would really differ.
std::string tiff(Input in, bool big_endian) {
  constexpr std::uint32_t kExifFolder = 0x8769, kTags[] = {0x829A, 0x829D, 0x8827, kExifFolder};
  constexpr std::uint32_t kEntries = 5, kFolderBytes = 2 + 12 * kEntries, kFirst = 8, kRationals = 16;
  std::string bytes = big_endian ? "MM" : "II";
  append(bytes, 42, 2, big_endian);
  append(bytes, kFirst, 4, big_endian);
  for (int folder = 0; folder < 2; ++folder) {
    append(bytes, kEntries, 2, big_endian);
    for (std::uint32_t i = 0; i < kEntries; ++i) {
      const std::uint32_t tag = kTags[in.byte() % 4];
      const std::uint32_t type = tag == kExifFolder ? 4 : 3 + in.byte() % 3;
      std::uint32_t value = in.byte();
      if (tag == kExifFolder) value = kFirst + value % 2 * kFolderBytes;
      if (type == 5) value = kFirst + 2 * kFolderBytes + 8 * (value % kRationals);
      append(bytes, tag, 2, big_endian);
      append(bytes, type, 2, big_endian);
      append(bytes, 1, 4, big_endian);
      append(bytes, value, type == 3 ? 2 : 4, big_endian);
      if (type == 3) append(bytes, 0, 2, big_endian);
    }
  }
  for (std::uint32_t i = 0; i < 2 * kRationals; ++i) append(bytes, in.bits<std::uint32_t>(), 4, big_endian);
  return bytes;
}

std::string in_jpeg(const std::string& content) {
  std::string bytes = "\xFF\xD8\xFF\xE1";
  append(bytes, static_cast<std::uint32_t>(content.size() + 8), 2, true);
  return bytes + std::string("Exif\0\0", 6) + content;
}

std::string in_png(const std::string& content) {
  std::string bytes = "\x89PNG\r\n\x1A\n";
  append(bytes, static_cast<std::uint32_t>(content.size()), 4, true);
  return bytes + "eXIf" + content + "sum.";
}

void exif_in_all_forms(Input in) {
  const std::string little = tiff(in, false), big = tiff(in, true);
  const auto exposure = read_exif_exposure(in_jpeg(little));
  expect_sensible(exposure);
  for (const std::string& file : {in_jpeg(big), in_png(little), in_png(big)}) {
    const auto same = read_exif_exposure(file);
    demand(same.has_value() == exposure.has_value(), "only one form has an exposure");
    if (same)
      demand(same->exposure_s == exposure->exposure_s && same->iso == exposure->iso &&
                 same->f_number == exposure->f_number,
             "another exposure");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr void (*kTargets[])(Input) = {arbitrary_file, damaged_file, exif_in_all_forms};
  Input in{{data, size}};
  const std::size_t target = in.byte() % std::size(kTargets);
  try {
    kTargets[target](in);
  } catch (const FileError&) {
  }
  return 0;
}
