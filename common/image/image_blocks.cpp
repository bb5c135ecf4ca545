// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_blocks.h"

namespace sheen {

std::optional<std::uint32_t> Integers::at(std::size_t place, std::size_t size) const {
  if (place > data_.size() || size > data_.size() - place) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
    value = value << 8 | static_cast<unsigned char>(data_[place + (big_endian_ ? i : size - 1 - i)]);
  return value;
}

std::string_view jpeg_segment(std::string_view file, std::uint16_t marker, std::string_view signature) {
  if (!file.starts_with("\xFF\xD8")) return {};
  const Integers integers(file, /*big_endian=*/true);
  for (std::size_t at = 2;;) {  // behind the start-of-image marker: segments of marker, length, content
    const auto found = integers.at(at, 2), length = integers.at(at + 2, 2);
    const bool is_segment = found && *found >= 0xFFE0 && *found <= 0xFFFE && length && *length >= 2;
    if (!is_segment) return {};
    const std::string_view content = file.substr(at + 4, *length - 2);
    if (*found == marker && content.starts_with(signature)) return content.substr(signature.size());
    if (file.size() - at < 2 + std::size_t(*length)) return {};
    at += 2 + *length;
  }
}

std::string_view png_chunk(std::string_view file, std::string_view type) {
  if (!file.starts_with("\x89PNG")) return {};
  const Integers integers(file, /*big_endian=*/true);
  for (std::size_t at = 8;;) {  // behind the signature: chunks of length, type, content, checksum
    const auto length = integers.at(at, 4);
    if (!length || file.size() - at < 12 + std::size_t(*length)) return {};
    if (file.substr(at + 4, 4) == type) return file.substr(at + 8, *length);
    at += 12 + std::size_t(*length);
  }
}

std::string_view webp_chunk(std::string_view file, std::string_view type) {
  if (!file.starts_with("RIFF") || !file.substr(0, 12).ends_with("WEBP")) return {};
  const Integers integers(file, /*big_endian=*/false);
  for (std::size_t at = 12;;) {  // behind RIFF, length, WEBP: chunks of type, length, content of an even length
    const auto length = integers.at(at + 4, 4);
    if (!length || file.size() - at < 8 + std::size_t(*length)) return {};
    if (file.substr(at, 4) == type) return file.substr(at + 8, *length);
    at += 8 + std::size_t(*length) + (*length & 1);
  }
}

}  // namespace sheen
