// SPDX-License-Identifier: Apache-2.0
#include "common/image/exif.h"

#include <cstdint>

namespace sheen {

namespace {

enum Tag : std::uint16_t {
  kOrientation = 0x0112,
  kExposureTime = 0x829A,
  kFNumber = 0x829D,
  kIso = 0x8827,
  kExifFolder = 0x8769
};
enum Type : std::uint16_t { kShort = 3, kLong = 4, kRational = 5 };

/// Bounds-checked integers of either byte order: empty past the end.
class Bytes {
 public:
  Bytes(std::string_view data, bool big_endian) : data_(data), big_endian_(big_endian) {}
  std::optional<std::uint32_t> integer(std::size_t at, std::size_t size) const {
    if (at > data_.size() || size > data_.size() - at) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value << 8 | static_cast<unsigned char>(data_[at + (big_endian_ ? i : size - 1 - i)]);
    return value;
  }

 private:
  std::string_view data_;
  bool big_endian_;
};

/// The value of `tag` in the folder at `folder`: a rational, or an integer that stands in the entry itself.
std::optional<double> find(const Bytes& tiff, std::size_t folder, std::uint16_t tag) {
  const auto count = tiff.integer(folder, 2);
  for (std::size_t i = 0; count && i < *count; ++i) {
    const std::size_t entry = folder + 2 + 12 * i;
    const auto found = tiff.integer(entry, 2), type = tiff.integer(entry + 2, 2);
    if (!found || !type) return std::nullopt;
    if (*found != tag) continue;
    const auto value = tiff.integer(entry + 8, *type == kShort ? 2 : 4);
    if (!value || *type == kShort || *type == kLong) return value;
    const auto numerator = tiff.integer(*value, 4), denominator = tiff.integer(std::size_t(*value) + 4, 4);
    if (*type != kRational || !numerator || !denominator || *denominator == 0) return std::nullopt;
    return double(*numerator) / *denominator;
  }
  return std::nullopt;
}

/// EXIF data and where in them the main folder stands.
struct Tiff {
  Bytes bytes;
  std::size_t main_folder;
};

std::optional<Tiff> read_tiff(std::string_view data) {
  const bool big_endian = data.starts_with("MM");
  if (!big_endian && !data.starts_with("II")) return std::nullopt;
  const Bytes bytes(data, big_endian);
  const auto main_folder = bytes.integer(4, 4);
  if (bytes.integer(2, 2) != 42u || !main_folder) return std::nullopt;
  return Tiff{bytes, *main_folder};
}

std::string_view exif_of_jpeg(std::string_view file) {
  const Bytes bytes(file, /*big_endian=*/true);
  constexpr std::string_view kSignature("Exif\0\0", 6);
  for (std::size_t at = 2;;) {  // behind the start-of-image marker: segments of marker, length, content
    const auto marker = bytes.integer(at, 2), length = bytes.integer(at + 2, 2);
    const bool is_segment = marker && *marker >= 0xFFE0 && *marker <= 0xFFFE && length && *length >= 2;
    if (!is_segment) return {};
    const std::string_view content = file.substr(at + 4, *length - 2);
    if (*marker == 0xFFE1 && content.starts_with(kSignature)) return content.substr(kSignature.size());
    if (file.size() - at < 2 + std::size_t(*length)) return {};
    at += 2 + *length;
  }
}

std::string_view exif_of_png(std::string_view file) {
  const Bytes bytes(file, /*big_endian=*/true);
  for (std::size_t at = 8;;) {  // behind the signature: chunks of length, type, content, checksum
    const auto length = bytes.integer(at, 4);
    if (!length || file.size() - at < 12 + std::size_t(*length)) return {};
    if (file.substr(at + 4, 4) == "eXIf") return file.substr(at + 8, *length);
    at += 12 + std::size_t(*length);
  }
}

std::string_view exif_of_webp(std::string_view file) {
  const Bytes bytes(file, /*big_endian=*/false);
  constexpr std::string_view kSignature("Exif\0\0", 6);
  for (std::size_t at = 12;;) {  // behind RIFF, length, WEBP: chunks of type, length, content of an even length
    const auto length = bytes.integer(at + 4, 4);
    if (!length || file.size() - at < 8 + std::size_t(*length)) return {};
    if (file.substr(at, 4) == "EXIF") {
      std::string_view content = file.substr(at + 8, *length);
      if (content.starts_with(kSignature))
        content.remove_prefix(kSignature.size());  // some programs write it here, too
      return content;
    }
    at += 8 + std::size_t(*length) + (*length & 1);
  }
}

std::optional<Tiff> find_tiff(std::string_view file) {
  if (file.starts_with("\xFF\xD8")) return read_tiff(exif_of_jpeg(file));
  if (file.starts_with("\x89PNG")) return read_tiff(exif_of_png(file));
  if (file.starts_with("RIFF") && file.substr(0, 12).ends_with("WEBP")) return read_tiff(exif_of_webp(file));
  return std::nullopt;
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

}  // namespace sheen
