// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common/plot/plot.h"
#include "tracker/calibration/photometric_study.h"

namespace sheen {

/// What a person reads.
std::string photometric_text(const PhotometricStudy& study);
/// What a program reads.
std::string photometric_json(const PhotometricStudy& study);

/// Draws into a folder: `response` (light of each value), `exposures` (by how much they err) and, where there is one,
/// `vignette` with `vignette_rings` (what the polynomial leaves). Throws FileError.
PlotFiles write_photometric_plots(const PhotometricStudy& study, const std::filesystem::path& folder);

}  // namespace sheen
