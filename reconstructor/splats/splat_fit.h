// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/base/progress.h"
#include "common/camera/posed_camera.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/splats/splats.h"

namespace sheen {

/// Something to be shown by splats.
struct SplatSubject {
  const Appearance& model;              ///< without holes (`ModelSnapshot::filled`)
  const ViewShader& mean_look;          ///< over all eyes
  std::span<const PosedCamera> images;  ///< that the model is of
};

struct FittedSplats {
  Splats splats;
  double psnr_db =
      0;  ///< of their pictures against the model's, encoded values, from eyes that they were not fitted to
};

/// About `count` Gaussians that look like a model. Their places, widths and opacities follow from the surface; their
/// colours are the least squares of the differences between their pictures and the model's, from many eyes between
/// those of its images and some all round it.
FittedSplats fit_splats(const SplatSubject& subject, std::size_t count, int degree, const StepsDone& progress = {});

}  // namespace sheen
