// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheen {

/// An include of one file by another.
struct Include {
  std::string file;    ///< path below the repository root
  int line = 0;        ///< from 1
  std::string target;  ///< what stands between the quotes or angle brackets
};

/// Includes of `text`, those behind // left out.
std::vector<Include> includes_of(const std::string& file, const std::string& text);

/// Includes of every .h and .cpp below common/, tracker/, reconstructor/ and tests/ of `root`.
std::vector<Include> includes_below(const std::filesystem::path& root);

/// One sentence per broken rule: file, line, what it includes, which rule forbids it.
std::vector<std::string> broken_include_rules(const std::vector<Include>& includes);

}  // namespace sheen
