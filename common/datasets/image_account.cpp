// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/image_account.h"

#include <algorithm>
#include <map>
#include <set>

#include "common/base/errors.h"
#include "common/datasets/file_finder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNamed = 10;

std::string key(const fs::path& path) {
  return path.lexically_normal().string();
}

std::set<std::string> keys(std::span<const fs::path> paths) {
  std::set<std::string> keys;
  for (const fs::path& path : paths) keys.insert(key(path));
  return keys;
}

/// Image files below a folder, sorted; at most so many levels and entries that a home folder does not take long.
std::vector<fs::path> image_files(const fs::path& root) {
  constexpr int kDepth = 3;
  constexpr int kEntries = 200'000;
  constexpr auto kOptions =
      fs::directory_options::skip_permission_denied | fs::directory_options::follow_directory_symlink;
  std::vector<fs::path> files;
  std::error_code error;
  int entries = 0;
  for (fs::recursive_directory_iterator at(root, kOptions, error), end; !error && at != end && entries < kEntries;
       at.increment(error), ++entries) {
    const fs::path& path = at->path();
    std::error_code ignored;
    const bool hidden = path.filename().string().starts_with('.');
    if (at->is_directory(ignored) && (hidden || at.depth() >= kDepth)) at.disable_recursion_pending();
    if (!hidden && is_image_name(path) && at->is_regular_file(ignored)) files.push_back(path);
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Whether a name is that of one of the images with something behind it (`r_0_depth_0001` beside `r_0`), or with
/// another extension.
bool belongs_to_image(const fs::path& file, const std::set<std::string>& stems) {
  const std::string stem = (file.parent_path() / file.stem()).string();
  const std::size_t folder = file.parent_path().string().size();
  for (std::size_t end = stem.size(); end != std::string::npos && end > folder; end = stem.find_last_of("_.-", end - 1))
    if (stems.contains(stem.substr(0, end))) return true;
  return false;
}

/// On one line, and without what a terminal would obey.
std::string shown(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
  return name;
}

/// "a, b and 3 others".
std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i) list += (i == 0 ? "" : ", ") + shown(names[i]);
  return names.size() > kNamed ? list + " and " + std::to_string(names.size() - kNamed) + " others" : list;
}

/// Folders in place of files, where many of one lie unused.
std::vector<std::string> by_folder(const std::vector<std::string>& files) {
  std::map<std::string, std::vector<std::string>> folders;
  for (const std::string& file : files) folders[fs::path(file).parent_path().string()].push_back(file);
  std::vector<std::string> names;
  for (const auto& [folder, within] : folders)
    if (within.size() > kNamed)
      names.push_back((folder.empty() ? "." : folder) + " (" + std::to_string(within.size()) + " files, such as " +
                      fs::path(within.front()).filename().string() + ")");
    else
      names.insert(names.end(), within.begin(), within.end());
  return names;
}

std::string count(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

}  // namespace

void look_for_unused(ImageAccount& account, const fs::path& root, std::span<const fs::path> images,
                     std::span<const fs::path> masks) {
  std::set<std::string> used = keys(images);
  std::set<std::string> folders, stems;
  for (const fs::path& image : images) {
    const fs::path normal = image.lexically_normal();
    folders.insert(normal.parent_path().string());
    stems.insert((normal.parent_path() / normal.stem()).string());
  }
  used.merge(keys(masks));
  for (const ImageAccount::LeftOut& left_out : account.left_out) used.insert(key(left_out.file));
  for (const fs::path& file : image_files(root)) {
    const fs::path normal = file.lexically_normal();
    if (used.contains(normal.string())) continue;
    account.unused.push_back(normal.lexically_relative(root.lexically_normal()).generic_string());
    if (folders.contains(normal.parent_path().string()) && !belongs_to_image(normal, stems)) ++account.of;
  }
}

void refuse_few(const fs::path& description, const ImageAccount& account) {
  const std::size_t named = account.images + account.left_out.size();
  if (account.left_out.empty() || (account.images > 0 && 2 * account.images >= named)) return;
  const ImageAccount::LeftOut& first = account.left_out.front();
  throw FileError(description.string(), "only " + std::to_string(account.images) + " of its " + std::to_string(named) +
                                            " images can be used; " + first.name + ": " + first.why);
}

std::string in_words(const ImageAccount& account, const fs::path& root) {
  std::string text = root.string() + ": " + std::to_string(account.images) + " of " + std::to_string(account.of) +
                     " images, " + std::to_string(account.masks);
  if (account.masks > 0 && account.masks < account.images) text += " of " + std::to_string(account.images);
  text += " masks";
  if (account.masks_are_alpha) text += " (alpha of the images)";
  if (account.unused_alphas > 0)
    text += "\nthe alpha of " + count(account.unused_alphas, "image is", "images is") + " not used: the mask file is";
  for (std::size_t i = 0; i < std::min(kNamed, account.left_out.size()); ++i)
    text += "\nleft out: " + shown(account.left_out[i].name + ": " + account.left_out[i].why);
  if (account.left_out.size() > kNamed)
    text += "\nleft out: " + std::to_string(account.left_out.size() - kNamed) + " others";
  if (!account.unused.empty())
    text += "\nnot used: " + count(account.unused.size(), "image file", "image files") +
            " in this folder: " + list_of(by_folder(account.unused));
  for (const auto& [space, images] : account.other_colours)
    text += "\n" + count(images.size(), "image is", "images are") + " of another colour space (" + space +
            "): " + list_of(images) + "; taken for sRGB, so colours come out a little wrong. Convert to sRGB first";
  if (!account.grey.empty())
    text += "\n" + std::to_string(account.grey.size()) + " of " + std::to_string(account.images) +
            " images are grey: " + list_of(account.grey) +
            "; the model takes them for colours. Leave them out, or make all of them grey";
  return text;
}

}  // namespace sheen
