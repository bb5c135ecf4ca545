// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace sheen {

/// The whole of a regular file. Throws FileError when it is missing, not a regular file, unreadable or longer than
/// `max_bytes`.
std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes = std::uintmax_t(1) << 34);

/// No more than its first `bytes`. Throws FileError likewise.
std::string read_file_start(const std::filesystem::path& path, std::size_t bytes);

/// Writes beside the target and renames, so that a crash or a full disk leaves the old file or the new one, never half
/// of one. What a process that was killed left of the same file (`NAME.PID.part`) is removed. A target that is not a
/// regular file (a pipe, a device) is written as it is. Throws FileError.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// The same for what must write a file by its name: `write` is given the unfinished file's.
void write_file(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write);

/// Tests whether `write_file` will work, to be called before long work whose result would be lost. Throws FileError
/// that says why not.
void check_writable(const std::filesystem::path& path);
/// The same for files in a folder, which may not exist yet; it is not created.
void check_writable_folder(const std::filesystem::path& folder);

/// Creates a folder and its parents where they do not exist yet. Throws FileError.
void make_folder(const std::filesystem::path& path);

/// A folder with files that belong together: they are written into `unfinished()`, which stands beside it
/// (`NAME.PID.part`) and takes its name when all of them are there. Else nothing is left, at the next time also of a
/// process that was killed.
class NewFolder {
 public:
  /// Throws FileError where anything but an empty folder has that name already, or where none can be made.
  explicit NewFolder(const std::filesystem::path& folder);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  const std::filesystem::path& unfinished() const { return unfinished_; }
  void finish();  ///< Throws FileError.

 private:
  std::filesystem::path folder_, unfinished_;
};

/// A path as seen from a folder, with slashes, where that can be said; else the whole path.
std::string relative_name(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace sheen
