// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace sheen {

/// Where `--json` puts a report: into a file, or with "-" to standard output, which then carries the report and nothing
/// else: from the constructor on, what is printed there goes to standard error.
class ReportFile {
 public:
  /// An empty path: no report is wanted. Throws FileError when the report could not be written: before the work.
  explicit ReportFile(std::filesystem::path path);
  ~ReportFile();
  ReportFile(const ReportFile&) = delete;
  ReportFile& operator=(const ReportFile&) = delete;

  bool wanted() const { return !path_.empty(); }
  /// Throws FileError.
  void write(std::string_view text);

 private:
  std::filesystem::path path_;
  int output_ = -1;  ///< standard output as it was, with "-"
};

/// Writes out what standard output still holds, as the last thing that a program does: a full disk is an
/// error. A reader that has closed the pipe is not. Throws FileError.
void finish_standard_output();

}  // namespace sheen
