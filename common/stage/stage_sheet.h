// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/stage/stage_layout.h"

namespace sheen {

/// The largest board whose sheet fits on paper of this size, lying on its longer side; metres.
struct BoardSize {
  double width_m = 0, height_m = 0;
};
BoardSize board_for_paper(double longer_m, double shorter_m);

/// Writes a stage to print, true to scale, by the file's ending: `.pdf` or `.svg`. One page: the board with a margin
/// round it, a bar of 100 mm below it to hold a ruler against (printers scale pages: print at 100 %, then measure), the
/// board's outline, the axes and the origin, and each tag's id beside the tag. Throws FileError, and ConfigError for
/// another ending.
void write_stage_sheet(const StageLayout& stage, const std::filesystem::path& path);

}  // namespace sheen
