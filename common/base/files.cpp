// SPDX-License-Identifier: Apache-2.0
#include "common/base/files.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "common/base/errors.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kUnfinished = ".part";

std::uintmax_t size_of(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw FileError(path.string(), "no such file");
  if (!fs::is_regular_file(status)) throw FileError(path.string(), "is not a regular file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw FileError(path.string(), "cannot be read: " + error.message());
  return size;
}

std::string read_bytes(const fs::path& path, std::size_t size) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw FileError(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::size_t>(in.gcount()) != size) throw FileError(path.string(), "could not be read to its end");
  return bytes;
}

fs::path unfinished_name(const fs::path& path) {
  return path.string() + "." + std::to_string(::getpid()) + std::string(kUnfinished);
}

bool is_no_regular_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// Files and folders with the unfinished name of a process that is no more.
void remove_abandoned(const fs::path& path) {
  const std::string start = path.filename().string() + ".";
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code error;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() <= start.size() + kUnfinished.size() || !name.starts_with(start) || !name.ends_with(kUnfinished))
      continue;
    const char* const last = name.data() + name.size() - kUnfinished.size();
    pid_t process = 0;
    const auto [parsed, failure] = std::from_chars(name.data() + start.size(), last, process);
    if (failure == std::errc() && parsed == last && process > 0 && ::kill(process, 0) != 0 && errno == ESRCH)
      abandoned.push_back(entry->path());
  }
  for (const fs::path& file : abandoned) fs::remove_all(file, error);
}

}  // namespace

std::string read_file(const fs::path& path, std::uintmax_t max_bytes) {
  const std::uintmax_t size = size_of(path);
  if (size > max_bytes)
    throw FileError(path.string(), "has " + std::to_string(size) + " bytes, more than the " +
                                       std::to_string(max_bytes) + " that such a file may have");
  return read_bytes(path, size);
}

std::string read_file_start(const fs::path& path, std::size_t bytes) {
  return read_bytes(path, std::min<std::uintmax_t>(size_of(path), bytes));
}

void write_file(const fs::path& path, std::string_view bytes) {
  write_file(path, [&](const fs::path& unfinished) {
    std::ofstream out(unfinished, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw FileError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
  });
}

void write_file(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  if (is_no_regular_file(path)) return write(path);
  remove_abandoned(path);
  const fs::path unfinished = unfinished_name(path);
  std::error_code error;
  try {
    write(unfinished);
    fs::rename(unfinished, path);
  } catch (const fs::filesystem_error& failure) {
    fs::remove(unfinished, error);
    throw FileError(path.string(), "cannot be written: " + failure.code().message());
  } catch (...) {
    fs::remove(unfinished, error);
    throw;
  }
}

void check_writable(const fs::path& path) {
  std::error_code error;
  if (path.filename().empty() || fs::is_directory(path, error))
    throw FileError(path.string(), "is a folder, not a file");
  const fs::path probe = is_no_regular_file(path) ? path : unfinished_name(path);
  const int file = ::open(probe.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) throw FileError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
  ::close(file);
  if (probe != path) fs::remove(probe, error);
}

void check_writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::path existing = fs::absolute(folder);
  while (!fs::exists(existing, error) && existing != existing.root_path()) existing = existing.parent_path();
  if (!fs::is_directory(existing, error)) throw FileError(folder.string(), existing.string() + " is not a folder");
  try {
    check_writable(existing / "probe");
  } catch (const FileError&) {
    throw FileError(folder.string(), "nothing can be written into " + existing.string());
  }
}

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw FileError(path.string(), "cannot be made: " + error.message());
}

NewFolder::NewFolder(const fs::path& folder)
    : folder_(folder.has_filename() ? folder : folder.parent_path()), unfinished_(unfinished_name(folder_)) {
  std::error_code error;
  if (fs::exists(folder_, error) && !(fs::is_directory(folder_, error) && fs::is_empty(folder_, error)))
    throw FileError(folder_.string(), "is there already; name a new folder");
  remove_abandoned(folder_);
  fs::remove_all(unfinished_, error);
  make_folder(unfinished_);
}

NewFolder::~NewFolder() {
  std::error_code ignored;
  fs::remove_all(unfinished_, ignored);
}

void NewFolder::finish() {
  std::error_code error;
  fs::remove(folder_, error);  // an empty one
  fs::rename(unfinished_, folder_, error);
  if (error) throw FileError(folder_.string(), "cannot be made: " + error.message());
}

std::string relative_name(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto whole = [](const std::filesystem::path& of) { return std::filesystem::absolute(of).lexically_normal(); };
  return whole(path).lexically_proximate(whole(folder)).generic_string();
}

}  // namespace sheen
