// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/base/progress.h"
#include "tracker/calibration/registration_report.h"

namespace sheen {

struct RegistrationOptions {
  bool free_scale = false;
  double unit_m = 1;  ///< metres per unit of the mesh's numbers
};

/// Where the mesh stands, by points (null: none were picked; the mesh stands about right as it is) and then by images
/// (empty: none). `views`: for pixels of points. Throws as its two parts do.
Registration register_mesh(const Mesh& mesh, const Correspondences* picked,
                           const std::map<std::string, PosedCamera>& views, std::span<const RegistrationImage> images,
                           const RegistrationOptions& options, const StepsDone& progress = {});

/// The mesh as it stands on the stage, metres.
Mesh placed(Mesh mesh, const Similarity& stage_from_mesh);

}  // namespace sheen
