// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/studies/experiment.h"

namespace sheen {

/// How much more a picture's error changes from triangle to triangle than within one.
struct SeamError {
  double across2 = 0, within2 = 0;     ///< sums of squared changes of the error
  std::size_t across = 0, within = 0;  ///< values: pairs of pixels times channels

  SeamError& operator+=(const SeamError& other);
  /// RMS change across edges over RMS change within triangles. 1 where the error changes nowhere; infinity where it
  /// changes at edges only; NaN where pairs of either kind are missing.
  double ratio() const;
};

/// Over pairs of pixels beside or below each other, both of the object (`object` not 0): the change of the error,
/// picture - truth in 8-bit values, from one to the other. A pair counts as within when both pixels show one triangle
/// and as across when they show two that have a corner's place in common; all others lie across a step in depth.
/// `hits`: first hits of the pixels, row by row. Pictures have 3 channels; sizes must agree.
SeamError seam_error(const Mesh& mesh, std::span<const Hit> hits, const ImageU8& picture, const ImageU8& truth,
                     const ImageU8& object);

/// What factorizing patches of a size costs and gains.
struct PatchRow {
  int triangles = 0;        ///< of a patch, at most
  std::size_t patches = 0;  ///< that images reached
  double factorize_ms = 0;  ///< mean wall time per image of folding columns
  double bytes = 0;         ///< of the patches' state
  double psnr_db = 0, ssim = 0;
  double seam = 0;  ///< `SeamError::ratio` over all held-out views
};

/// The light field with patches of each of these sizes. The surface bends at edges, so errors change there whatever the
/// patch: the seam figure of one size says something only beside that of others.
std::vector<PatchRow> study_patches(const Experiment& experiment, const SurfaceLightFieldOptions& options,
                                    std::span<const int> sizes);

}  // namespace sheen
