// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "reconstructor/studies/experiment.h"

namespace sheen {

/// What a number format of the factorization costs and gains, on a scene's own columns.
struct PrecisionRow {
  const char* name;
  double column_us = 0;       ///< processor time of folding a column in, one thread
  double patch_bytes = 0;     ///< mean, of what is kept: the whole state, or the stored terms alone
  double relative_error = 0;  ///< ||C - B Y|| / ||C|| of the displayed terms, known values of all patches together
  double difference = 0;      ///< of B Y from that of double precision, relative to ||C||
};

struct PrecisionStudy {
  std::size_t patches = 0, columns = 0;
  PrecisionRow single{.name = "float"}, twice{.name = "double"};
  /// The displayed terms of `single` as a saved model would hold them, in single and in half precision: no time.
  PrecisionRow stored{.name = "stored as float"}, stored_half{.name = "stored as half"};
  double psnr_db = 0, psnr_half_db = 0;  ///< of the held-out views: the light field, and its terms rounded to half
};

/// Folds the columns of about `patches` patches, spread over the mesh, with what each image hides of them, in single
/// and in double precision, patch by patch in turn. `whole`: the light field of these images and options.
PrecisionStudy study_precision(const Experiment& experiment, const SurfaceLightFieldOptions& options,
                               const SurfaceLightFieldSnapshot& whole, std::size_t patches = 300);

}  // namespace sheen
