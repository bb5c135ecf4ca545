// SPDX-License-Identifier: Apache-2.0
#include "common/base/report_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "common/base/errors.h"
#include "common/base/files.h"

namespace sheen {
namespace {

/// A stream may have failed long before it is asked, and has forgotten why.
[[noreturn]] void fail_output() {
  throw FileError("standard output", errno != 0 ? std::string("cannot be written: ") + std::strerror(errno)
                                                : "cannot be written; is the disk full?");
}

void write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno != EINTR) fail_output();
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

ReportFile::ReportFile(std::filesystem::path path) : path_(std::move(path)) {
  if (path_.empty()) return;
  if (path_ != "-") {
    check_writable(path_);
    return;
  }
  std::fflush(stdout);
  output_ = ::dup(STDOUT_FILENO);
  if (output_ < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) fail_output();
}

ReportFile::~ReportFile() {
  if (output_ < 0) return;
  std::cout.flush();
  std::fflush(stdout);
  ::dup2(output_, STDOUT_FILENO);
  ::close(output_);
}

void ReportFile::write(std::string_view text) {
  if (output_ >= 0)
    write_all(output_, text);
  else if (wanted())
    write_file(path_, text);
}

void finish_standard_output() {
  errno = 0;
  std::cout.flush();
  if (std::cout && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  if (errno != EPIPE) fail_output();
}

}  // namespace sheen
