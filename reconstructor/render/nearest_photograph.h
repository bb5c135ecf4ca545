// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// Further from all photographs than this, a picture shows what was seen from elsewhere.
inline constexpr double kFarFromPhotographsDeg = 15;

/// Between an eye (object frame) and the nearest of the model's cameras, seen from the middle of the object: 0..180
/// degrees. NaN where the model has no cameras.
double nearest_photograph_deg(const ModelSnapshot& model, const Eigen::Vector3d& eye);

/// "no photograph from here: the nearest is 34 degrees away"; empty where one is near, or there is none at all.
std::string no_photograph_note(const ModelSnapshot& model, const Eigen::Vector3d& eye);

}  // namespace sheen
