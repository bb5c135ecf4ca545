// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/simulation/reflectance.h"

namespace sheen {

/// Old bronze at a place in the object frame (metres): nearly all light comes from the lobe, whose tint and width vary
/// from hammer marks down to grain; engraved lines, spots of dull green patina.
struct Bronze {
  Material operator()(const Eigen::Vector3f& point) const;
};

}  // namespace sheen
