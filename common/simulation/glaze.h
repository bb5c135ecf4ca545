// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/simulation/reflectance.h"

namespace sheen {

/// Glaze of the demo's objects at a place in the object frame (metres): a gradient that is warped by noise, vertical
/// runs, cream spots of 1-2 mm with dark rims, fine speckle, hairline cracks, gold bands, an unglazed foot; gloss and
/// strength of the lobe vary with it. `band_heights` are those of the gold bands.
struct Glaze {
  float foot_height = 0.009f;  ///< metres, unglazed below
  float top_height = 0.106f;   ///< metres, where the gradient ends
  Eigen::Array3f band_heights{0.019f, 0.0806f, 0.107f};

  Material operator()(const Eigen::Vector3f& point) const;
};

}  // namespace sheen
