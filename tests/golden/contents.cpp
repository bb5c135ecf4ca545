// SPDX-License-Identifier: Apache-2.0
#include "tests/golden/contents.h"

#include <algorithm>
#include <cstdlib>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "common/base/crc32c.h"
#include "reconstructor/irradiance_field_file/field_reader.h"
#include "reconstructor/light_field_file/light_field_file.h"

namespace sheen {

FileContents::Part Checksum::part(const std::string& name) const {
  return {name, crc32c(bytes_)};
}

std::uint8_t value_of_255(float grey_level) {
  return static_cast<std::uint8_t>(std::clamp(grey_level + 0.5f, 0.0f, 255.0f));
}

FileContents contents_of(std::string_view bytes, const std::string& file) {
  if (is_light_field_file(bytes)) return contents_of_light_field(bytes, file);
  if (is_field_file(bytes)) return contents_of_irradiance_field(bytes, file);
  return contents_of_lumigraph(bytes, file);
}

std::string FileContents::text() const {
  std::ostringstream out;
  for (const Part& part : whole_numbers) out << part.name << ' ' << std::hex << part.checksum << std::dec << '\n';
  for (const auto& picture : pictures) {
    out << "picture";
    for (const std::uint8_t value : picture) out << ' ' << int{value};
    out << '\n';
  }
  return out.str();
}

FileContents FileContents::parsed(std::string_view text) {
  FileContents contents;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    if (name == "picture") {
      auto& picture = contents.pictures.emplace_back();
      for (int value; words >> value;) picture.push_back(static_cast<std::uint8_t>(value));
      continue;
    }
    Part part{.name = name};
    if (!(words >> std::hex >> part.checksum)) throw std::runtime_error("not a line of contents: " + line);
    contents.whole_numbers.push_back(part);
  }
  return contents;
}

std::string differences(const FileContents& expected, const FileContents& found) {
  std::ostringstream out;
  if (expected.whole_numbers.size() != found.whole_numbers.size() || expected.pictures.size() != found.pictures.size())
    out << "other parts\n";
  for (std::size_t i = 0; i < std::min(expected.whole_numbers.size(), found.whole_numbers.size()); ++i)
    if (expected.whole_numbers[i] != found.whole_numbers[i]) out << found.whole_numbers[i].name << " differ\n";
  for (std::size_t p = 0; p < std::min(expected.pictures.size(), found.pictures.size()); ++p) {
    const auto &a = expected.pictures[p], &b = found.pictures[p];
    int most = a.size() == b.size() ? 0 : 255;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    if (most > 1) out << "picture " << p << " differs by " << most << " of 255\n";
  }
  return out.str();
}

}  // namespace sheen
