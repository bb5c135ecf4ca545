// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr_attributes.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <string>

#include "common/base/errors.h"

namespace sheen {

namespace {

constexpr std::uint32_t kMagic = 20000630;    // what makes it an EXR
constexpr std::uint32_t kMultiPart = 0x1000;  // flag beside the version

/// Types whose values are all of one size, in bytes.
const std::map<std::string, std::uint32_t> kFixedSizes = {
    {"box2f", 16},
    {"box2i", 16},
    {"chromaticities", 32},
    {"compression", 1},
    {"deepImageState", 1},
    {"double", 8},
    {"envmap", 1},
    {"float", 4},
    {"int", 4},
    {"keycode", 28},
    {"lineOrder", 1},
    {"m33d", 72},
    {"m33f", 36},
    {"m44d", 128},
    {"m44f", 64},
    {"rational", 8},
    {"tiledesc", 9},
    {"timecode", 8},
    {"v2d", 16},
    {"v2f", 8},
    {"v2i", 8},
    {"v3d", 24},
    {"v3f", 12},
    {"v3i", 12},
};

/// Little endian.
std::uint32_t number_at(const char* bytes) {
  unsigned char b[4];
  std::memcpy(b, bytes, sizeof b);
  return b[0] | std::uint32_t(b[1]) << 8 | std::uint32_t(b[2]) << 16 | std::uint32_t(b[3]) << 24;
}

std::uint32_t read_number(std::istream& file) {
  char bytes[4] = {};
  file.read(bytes, sizeof bytes);
  return number_at(bytes);
}

/// Names, each followed by a pixel type, flags and samplings; an empty name ends them. @return whether they fill
/// `value`
bool is_channel_list(const std::string& value) {
  constexpr std::size_t kPerChannel = 16;
  std::size_t at = 0;
  while (at < value.size()) {
    const std::size_t end = value.find('\0', at);
    if (end == std::string::npos) return false;
    if (end == at) return end + 1 == value.size();
    at = end + 1 + kPerChannel;
  }
  return false;
}

/// Strings, each behind its length. @return whether they fill `value`
bool is_string_vector(const std::string& value) {
  std::size_t at = 0;
  while (value.size() - at >= 4) {
    const std::uint32_t length = number_at(value.data() + at);
    at += 4;
    if (length > value.size() - at) return false;
    at += length;
  }
  return at == value.size();
}

/// Width and height, then as many pixels of 4 bytes.
bool is_preview(const std::string& value) {
  if (value.size() < 8) return false;
  return std::uint64_t(number_at(value.data())) * number_at(value.data() + 4) == (value.size() - 8) / 4 &&
         value.size() % 4 == 0;
}

/// Whether a value of this type is as long as the attribute says; one of an unknown type, or of text, always is.
bool has_its_size(const std::string& type, const std::string& value) {
  if (const auto fixed = kFixedSizes.find(type); fixed != kFixedSizes.end()) return value.size() == fixed->second;
  if (type == "chlist") return is_channel_list(value);
  if (type == "stringvector") return is_string_vector(value);
  if (type == "preview") return is_preview(value);
  if (type == "floatvector") return value.size() % 4 == 0;
  return true;
}

}  // namespace

void check_exr_attributes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::uintmax_t file_bytes = std::filesystem::file_size(path);
  if (read_number(file) != kMagic) throw Error("it is a file of another kind");
  const bool several = read_number(file) & kMultiPart;
  std::string name, type;
  for (bool in_header = false; std::getline(file, name, '\0');) {
    if (name.empty()) {  // the end of a header; a header without anything is the end of them
      if (!several || !in_header) return;
      in_header = false;
      continue;
    }
    in_header = true;
    std::getline(file, type, '\0');
    const std::uint32_t size = read_number(file);
    const auto fail = [&](const std::string& what) {
      throw Error("attribute \"" + name.substr(0, 40) + "\" claims " + std::to_string(size) + " bytes, " + what);
    };
    if (!file || size > file_bytes - static_cast<std::uintmax_t>(file.tellg())) fail("more than the file holds");
    std::string value(size, '\0');
    file.read(value.data(), size);
    if (!has_its_size(type, value)) fail("which a " + type.substr(0, 40) + " has not");
  }
}

}  // namespace sheen
