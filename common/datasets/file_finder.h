// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace sheen {

/// A name in the form in which two names of one file are equal, on whichever system either was written: composed
/// letters, without upper case. Bytes that are no UTF-8 stay as they are.
std::string loose_name(const std::string& name);

/// A path with slashes, without "." and where it can be without "..", from one that may have backslashes.
std::string normal_name(const std::string& name);

/// Finds files of a data set by the names that its description has: as written; else with slashes for backslashes;
/// else with letters composed or decomposed, upper or lower case, where just one file is meant; else, of a path of
/// another machine or one that begins with the end of the root's own, the part that lies below the root.
class FileFinder {
 public:
  explicit FileFinder(std::filesystem::path root) : root_(std::move(root)) {}

  /// Empty when there is no such file.
  std::filesystem::path find(const std::string& name) const;
  /// The same; the name may lack the extension of an image file.
  std::filesystem::path find_image(const std::string& name) const;

 private:
  using Listing = std::multimap<std::string, std::string>;  // loose name to name
  const Listing& listing(const std::filesystem::path& folder) const;
  std::filesystem::path entry(const std::filesystem::path& folder, const std::string& name) const;
  std::filesystem::path find_parts(const std::vector<std::string>& parts, std::size_t first) const;
  std::filesystem::path find_loosely(const std::string& name) const;

  std::filesystem::path root_;
  mutable std::map<std::filesystem::path, Listing> listings_;
};

/// Whether a file is an image by its extension, of whichever case: one that is read, or one that is not (TIFF, HEIC).
bool is_image_name(const std::filesystem::path& path);

}  // namespace sheen
