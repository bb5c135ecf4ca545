// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/plain_names.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/capture/capture_validation.h"
#include "common/datasets/file_finder.h"

namespace sheen {
namespace {

constexpr std::size_t kLongest = 100;  ///< bytes of a part; room is left for extensions

bool is_plain(unsigned char c) {
  return std::isalnum(c) || c >= 0x80 || c == '-' || c == '_' || c == '.';
}

std::string plain_part(std::string part, bool folder) {
  if (part.size() > kLongest) part.resize(kLongest);
  while (!is_plain_text(part) && !part.empty() && static_cast<unsigned char>(part.back()) >= 0x80) part.pop_back();
  std::replace_if(
      part.begin(), part.end(), [&](unsigned char c) { return !is_plain(c) || (folder && c == '.'); }, '_');
  if (part.empty() || part.front() == '.' || part.front() == '-') part.replace(0, 1, "_");
  return part;
}

/// What stands between slashes, without what leads upwards or to a root.
std::vector<std::string> parts_of(const std::string& name) {
  std::vector<std::string> parts;
  for (const auto& part : std::filesystem::path(normal_name(name)).relative_path())
    if (!part.empty() && part != "." && part != "..") parts.push_back(part.string());
  if (parts.size() > 1 && parts.front() == "images") parts.erase(parts.begin());
  if (parts.empty()) parts.emplace_back("view");
  return parts;
}

}  // namespace

std::string PlainNames::take(const std::string& name) {
  std::string valid = name;
  if (!is_plain_text(name))
    std::replace_if(
        valid.begin(), valid.end(), [](unsigned char c) { return c >= 0x80 || c < 0x20; }, '_');
  std::vector<std::string> parts = parts_of(valid);
  if (is_image_name(parts.back())) parts.back() = std::filesystem::path(parts.back()).stem().string();
  std::string plain;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) plain += plain_part(parts[i], true) + "/";
  plain += plain_part(parts.back(), false);
  std::string alone = plain;
  for (int n = 2; !taken_.insert(loose_name(alone)).second; ++n) alone = plain + "-" + std::to_string(n);
  return alone;
}

}  // namespace sheen
