// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/session/session_index.h"

namespace sheen {

/// What an index should hold, given what it holds and which capture files there are.
struct SessionRepair {
  IndexContents contents;
  bool changed = false;                          ///< whether `contents` differs from what the index holds
  std::vector<std::string> findings;             ///< a line each, for a person
  std::map<std::string, std::string> set_aside;  ///< files that are no captures of this session: name -> new name
};

/// Reads the folder, changes nothing. Rows and files are matched by name; the order of the captures is that of the
/// files' numbers.
///  - A file without a row gets one if it is a whole capture, of which no other file is a copy; else it is to be set
///    aside.
///  - A row whose file is missing or damaged stays: the capture counts, and cannot be read.
///  - A row that makes no sense is rebuilt from its file, or dropped if it has none.
///  - Marks follow their captures to new indices; those of no capture are dropped.
///  - Files that are not named as captures are left alone.
SessionRepair plan_repair(const IndexContents& index, const std::filesystem::path& captures);

/// Whether a folder has files that are named as captures. False for one that is missing.
bool has_capture_files(const std::filesystem::path& captures);

}  // namespace sheen
