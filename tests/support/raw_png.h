// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace sheen {

/// A PNG written byte by byte, of any depth and colour type, without compression: what our writer does not write.
struct RawPng {
  std::uint32_t width = 1, height = 1;
  std::uint8_t depth = 8, colour_type = 0;                  ///< as in IHDR
  std::vector<std::pair<std::string, std::string>> chunks;  ///< before the pixels: PLTE, tRNS, eXIf
  std::string pixels;                                       ///< rows without their filter bytes
  std::vector<std::pair<std::string, std::string>> behind;  ///< the pixels

  /// What the file begins with: signature and IHDR.
  std::string header() const {
    return std::string("\x89PNG\r\n\x1a\n", 8) +
           chunk("IHDR", big(width) + big(height) + std::string{char(depth), char(colour_type), 0, 0, 0});
  }
  std::string bytes() const {
    std::string file = header();
    for (const auto& [type, data] : chunks) file += chunk(type, data);
    file += chunk("IDAT", stored(rows()));
    for (const auto& [type, data] : behind) file += chunk(type, data);
    return file + chunk("IEND", "");
  }

 private:
  static std::string big(std::uint32_t v) { return {char(v >> 24), char(v >> 16), char(v >> 8), char(v)}; }
  static std::string chunk(const std::string& type, const std::string& data) {
    std::uint32_t crc = 0xffffffffu;
    for (const unsigned char byte : type + data) {
      crc ^= byte;
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return big(std::uint32_t(data.size())) + type + data + big(~crc);
  }
  std::string rows() const {
    std::string all;
    const std::size_t row = pixels.size() / height;
    for (std::uint32_t y = 0; y < height; ++y) all += '\0' + pixels.substr(y * row, row);
    return all;
  }
  /// zlib data of one stored block: at most 65535 bytes.
  static std::string stored(const std::string& data) {
    std::uint32_t a = 1, b = 0;
    for (const unsigned char byte : data) b = (b + (a = (a + byte) % 65521)) % 65521;
    const auto size = std::uint16_t(data.size());
    const auto little = [](std::uint16_t v) { return std::string{char(v), char(v >> 8)}; };
    return std::string("\x78\x01\x01", 3) + little(size) + little(std::uint16_t(~size)) + data + big(b << 16 | a);
  }
};

}  // namespace sheen
