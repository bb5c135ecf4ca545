// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/file_finder.h"

#include <glib.h>

#include <algorithm>
#include <memory>
#include <string_view>

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRead[] = {".png", ".jpg", ".jpeg", ".webp", ".exr"};
constexpr const char* kNotRead[] = {".tif", ".tiff", ".bmp", ".heic", ".avif", ".gif"};

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::string with_slashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

/// What stands between slashes, without ".".
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (const fs::path& part : fs::path(path).lexically_normal())
    if (!part.empty() && part != "." && part != "/") parts.push_back(part.string());
  return parts;
}

bool is_absolute(const std::string& path) {
  const bool drive = path.size() > 1 && g_ascii_isalpha(path[0]) && path[1] == ':';
  return path.starts_with('/') || drive;
}

}  // namespace

std::string loose_name(const std::string& name) {
  const auto owned = [](char* text) { return std::unique_ptr<char, decltype(&g_free)>(text, g_free); };
  const auto composed =
      owned(g_utf8_normalize(name.data(), static_cast<gssize>(name.size()), G_NORMALIZE_DEFAULT_COMPOSE));
  if (!composed) return name;
  return owned(g_utf8_casefold(composed.get(), -1)).get();
}

std::string normal_name(const std::string& name) {
  return fs::path(with_slashes(name)).lexically_normal().generic_string();
}

const FileFinder::Listing& FileFinder::listing(const fs::path& folder) const {
  const auto [found, is_new] = listings_.try_emplace(folder);
  if (!is_new) return found->second;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    found->second.emplace(loose_name(name), name);
  }
  return found->second;
}

/// Empty where none or several have that name.
fs::path FileFinder::entry(const fs::path& folder, const std::string& name) const {
  std::error_code ignored;
  if (name == ".." || fs::exists(folder / name, ignored)) return folder / name;
  const auto [first, last] = listing(folder).equal_range(loose_name(name));
  if (first == last || std::next(first) != last) return {};
  return folder / first->second;
}

fs::path FileFinder::find_parts(const std::vector<std::string>& parts, std::size_t first) const {
  fs::path path = root_;
  for (std::size_t i = first; i < parts.size() && !path.empty(); ++i) path = entry(path, parts[i]);
  return is_file(path) ? path : fs::path();
}

fs::path FileFinder::find_loosely(const std::string& name) const {
  const std::string path = with_slashes(name);
  const std::vector<std::string> parts = parts_of(path), of_root = parts_of(fs::absolute(root_).string());
  const bool anywhere = is_absolute(path);
  for (std::size_t first = 0; first < parts.size(); ++first) {
    const auto begun = static_cast<std::ptrdiff_t>(first);
    const bool ends_root =
        first <= of_root.size() && std::equal(parts.begin(), parts.begin() + begun, of_root.end() - begun);
    if (!anywhere && !ends_root) continue;
    if (const fs::path found = find_parts(parts, first); !found.empty()) return found;
  }
  return {};
}

fs::path FileFinder::find(const std::string& name) const {
  if (const fs::path path = root_ / fs::path(name).lexically_normal(); is_file(path)) return path;
  return find_loosely(name);
}

fs::path FileFinder::find_image(const std::string& name) const {
  if (const fs::path path = find(name); !path.empty()) return path;
  for (const char* extension : kRead)
    if (const fs::path path = find(name + extension); !path.empty()) return path;
  return {};
}

bool is_image_name(const fs::path& path) {
  const std::string extension = loose_name(path.extension().string());
  const auto has = [&](const auto& list) {
    return std::find(std::begin(list), std::end(list), extension) != std::end(list);
  };
  return has(kRead) || has(kNotRead);
}

}  // namespace sheen
