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

/// Numbers as they would stand in memory that is little-endian.
class Checksum {
 public:
  void add(std::int64_t number) {
    for (int byte = 0; byte < 8; ++byte) bytes_.push_back(static_cast<std::uint8_t>(number >> (8 * byte)));
  }
  template <typename Numbers>
  void add_all(const Numbers& numbers) {
    add(static_cast<std::int64_t>(numbers.size()));
    for (const auto number : numbers) add(static_cast<std::int64_t>(number));
  }
  FileContents::Part part(const std::string& name) const;

 private:
  std::vector<std::uint8_t> bytes_;
};

std::uint8_t value_of_255(float grey_level);

// Of a file of each kind. Throw FileError.
FileContents contents_of_light_field(std::string_view bytes, const std::string& file);
FileContents contents_of_irradiance_field(std::string_view bytes, const std::string& file);
FileContents contents_of_lumigraph(std::string_view bytes, const std::string& file);
/// By how the file begins.
FileContents contents_of(std::string_view bytes, const std::string& file);

/// What differs, a line each; empty where nothing does.
std::string differences(const FileContents& expected, const FileContents& found);

}  // namespace sheen
