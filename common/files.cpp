// SPDX-License-Identifier: Apache-2.0
#include "common/files.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "common/errors.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

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
  const fs::path unfinished = path.string() + "." + std::to_string(::getpid()) + ".part";
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

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw FileError(path.string(), "cannot be made: " + error.message());
}

}  // namespace sheen
