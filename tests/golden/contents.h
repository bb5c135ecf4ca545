// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sheen {

/// What a small model file holds, as far as all builds must agree on it.
struct FileContents {
  struct Part {
    std::string name;
    std::uint32_t checksum = 0;
    bool operator==(const Part&) const = default;
  };
  std::vector<Part> whole_numbers;                  ///< equal to the last bit
  std::vector<std::vector<std::uint8_t>> pictures;  ///< values of 255, each within 1

  std::string text() const;
  /// Throws std::runtime_error where a line is none of `text`.
  static FileContents parsed(std::string_view text);
};

/// Throws FileError.
FileContents contents_of_light_field(std::string_view bytes, const std::string& file);

/// What differs, a line each; empty where nothing does.
std::string differences(const FileContents& expected, const FileContents& found);

}  // namespace sheen
