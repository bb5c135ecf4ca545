// SPDX-License-Identifier: Apache-2.0
#include "common/image/exif.h"

#include <cstdint>

#include "common/image/image_blocks.h"

namespace sheen {

namespace {

enum Tag : std::uint16_t {
  kOrientation = 0x0112,
  kExposureTime = 0x829A,
  kFNumber = 0x829D,
  kIso = 0x8827,
  kColourSpace = 0xA001,
  kExifFolder = 0x8769
};
enum Type : std::uint16_t { kShort = 3, kLong = 4, kRational = 5 };

/// The value of `tag` in the folder at `folder`: a rational, or an integer that stands in the entry itself.
std::optional<double> find(const Integers& tiff, std::size_t folder, std::uint16_t tag) {
  const auto count = tiff.at(folder, 2);
  for (std::size_t i = 0; count && i < *count; ++i) {
    const std::size_t entry = folder + 2 + 12 * i;
    const auto found = tiff.at(entry, 2), type = tiff.at(entry + 2, 2);
    if (!found || !type) return std::nullopt;
    if (*found != tag) continue;
    const auto value = tiff.at(entry + 8, *type == kShort ? 2 : 4);
    if (!value || *type == kShort || *type == kLong) return value;
    const auto numerator = tiff.at(*value, 4), denominator = tiff.at(std::size_t(*value) + 4, 4);
    if (*type != kRational || !numerator || !denominator || *denominator == 0) return std::nullopt;
    return double(*numerator) / *denominator;
  }
  return std::nullopt;
}

/// EXIF data and where in them the main folder stands.
struct Tiff {
  Integers bytes;
  std::size_t main_folder;
};

std::optional<Tiff> read_tiff(std::string_view data) {
  const bool big_endian = data.starts_with("MM");
  if (!big_endian && !data.starts_with("II")) return std::nullopt;
  const Integers bytes(data, big_endian);
  const auto main_folder = bytes.at(4, 4);
  if (bytes.at(2, 2) != 42u || !main_folder) return std::nullopt;
  return Tiff{bytes, *main_folder};
}

std::optional<Tiff> find_tiff(std::string_view file) {
  constexpr std::string_view kSignature("Exif\0\0", 6);
  std::string_view content = jpeg_segment(file, 0xFFE1, kSignature);
  if (content.empty()) content = png_chunk(file, "eXIf");
  if (content.empty()) content = webp_chunk(file, "EXIF");
  if (content.starts_with(kSignature)) content.remove_prefix(kSignature.size());  // some programs write it in WebP, too
  return read_tiff(content);
}

}  // namespace

std::optional<ExifExposure> read_exif_exposure(std::string_view file) {
  const auto tiff = find_tiff(file);
  const auto folder = tiff ? find(tiff->bytes, tiff->main_folder, kExifFolder) : std::nullopt;
  if (!folder) return std::nullopt;
  const auto at = static_cast<std::size_t>(*folder);
  const auto exposure = find(tiff->bytes, at, kExposureTime);
  if (!exposure || !(*exposure > 0)) return std::nullopt;
  return ExifExposure{*exposure, find(tiff->bytes, at, kIso).value_or(0), find(tiff->bytes, at, kFNumber).value_or(0)};
}

int read_exif_orientation(std::string_view file) {
  const auto tiff = find_tiff(file);
  const double value = tiff ? find(tiff->bytes, tiff->main_folder, kOrientation).value_or(1) : 1;
  return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
}

bool exif_says_other_colours(std::string_view file) {
  const auto tiff = find_tiff(file);
  const auto folder = tiff ? find(tiff->bytes, tiff->main_folder, kExifFolder) : std::nullopt;
  const auto space = folder ? find(tiff->bytes, static_cast<std::size_t>(*folder), kColourSpace) : std::nullopt;
  return space && *space != 1;
}

}  // namespace sheen
