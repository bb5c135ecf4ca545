// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/simulation/reflectance.h"

namespace sheen {

/// Polished lacquer at a place in the object frame (metres): dark red that turns black upwards, gold dust where the two
/// meet, gold bands. Highlights are bright and narrow, and move over it with the eye.
struct Lacquer {
  Material operator()(const Eigen::Vector3f& point) const;
};

}  // namespace sheen
