// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace sheen {

/// Bounds-checked integers of either byte order: empty past the end.
class Integers {
 public:
  Integers(std::string_view data, bool big_endian) : data_(data), big_endian_(big_endian) {}
  /// `size` bytes, at most 4.
  std::optional<std::uint32_t> at(std::size_t place, std::size_t size) const;

 private:
  std::string_view data_;
  bool big_endian_;
};

/// What an image file says beside its pixels: the content of a JPEG segment that begins with `signature`, without it,
/// of a PNG chunk or of a WebP chunk. Empty where the file has none or is another kind of file.
std::string_view jpeg_segment(std::string_view file, std::uint16_t marker, std::string_view signature);
std::string_view png_chunk(std::string_view file, std::string_view type);
std::string_view webp_chunk(std::string_view file, std::string_view type);

}  // namespace sheen
