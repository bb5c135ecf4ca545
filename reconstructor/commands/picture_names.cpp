// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/picture_names.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace sheen {
namespace {

using Parts = std::vector<std::string>;

bool is_picture(std::string extension) {
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg" || extension == ".exr";
}

/// Folders and file name, without what leads upwards or to a root.
Parts parts_of(const std::string& view) {
  Parts parts;
  for (const auto& part : std::filesystem::path(view).lexically_normal().relative_path())
    if (!part.empty() && part != "." && part != "..") parts.push_back(part.string());
  if (parts.empty()) parts.push_back("view");
  return parts;
}

/// The number of folders that all views begin with.
std::size_t shared_folders(const std::vector<Parts>& views) {
  std::size_t shared = views.empty() ? 0 : views.front().size() - 1;
  for (const Parts& view : views) {
    const auto end = view.begin() + static_cast<std::ptrdiff_t>(std::min(shared, view.size() - 1));
    shared = static_cast<std::size_t>(std::mismatch(view.begin(), end, views.front().begin()).first - view.begin());
  }
  return shared;
}

}  // namespace

std::vector<std::filesystem::path> picture_names(const std::vector<std::string>& views) {
  std::vector<Parts> all;
  for (const std::string& view : views) all.push_back(parts_of(view));
  const std::size_t shared = shared_folders(all);
  std::vector<std::filesystem::path> names;
  std::set<std::filesystem::path> taken;
  for (const Parts& parts : all) {
    std::filesystem::path whole;
    for (std::size_t i = shared; i < parts.size(); ++i) whole /= parts[i];
    std::filesystem::path name = whole;
    if (is_picture(whole.extension().string())) name.replace_extension();
    if (taken.contains(name)) name = whole;  // a.png beside a.jpg
    for (int n = 2; !taken.insert(name).second; ++n) name = whole.string() + "-" + std::to_string(n);
    names.push_back(name);
  }
  return names;
}

}  // namespace sheen
