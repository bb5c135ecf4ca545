// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/plot/plot.h"
#include "tracker/calibration/calibration_study.h"

namespace sheen {

/// Draws into a folder: `images` (RMS of each), `uncertainty` (of a pixel, with the corners seen) and `halves` (by how
/// much the cameras of two halves differ). Throws FileError.
PlotFiles write_calibration_plots(const CalibrationStudy& study, const std::filesystem::path& folder);

}  // namespace sheen
