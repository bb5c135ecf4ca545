// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "reconstructor/studies/experiment.h"

namespace sheen {

/// The small file of a light field that may lose so much.
struct SmallFileRow {
  double asked_db = 0;    ///< loss of PSNR that is allowed
  std::size_t bytes = 0;  ///< of the file, without what is noted in it
  double seconds = 0;     ///< wall time of finding it
  double psnr_db = 0, ssim = 0;
};

/// One file for each of these losses.
std::vector<SmallFileRow> study_small_files(const Experiment& experiment, const SurfaceLightFieldSnapshot& light_field,
                                            std::span<const double> losses_db);

}  // namespace sheen
