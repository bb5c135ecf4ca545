// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/stage/stage_layout.h"

namespace sheen {

/// Writes a stage to print, true to scale, by the file's ending: `.pdf` or `.svg`. One page: the board with a margin
/// round it, a bar of 100 mm below it to hold a ruler against (printers scale pages: print at 100 %, then measure), the
/// board's outline, the axes and the origin, and each tag's id beside the tag. Throws FileError, and ConfigError for
/// another ending.
void write_stage_sheet(const StageLayout& stage, const std::filesystem::path& path);

}  // namespace sheen
