// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/nearest_photograph.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {

double nearest_photograph_deg(const ModelSnapshot& model, const Eigen::Vector3d& eye) {
  if (model.cameras().empty()) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d centre = bounding_sphere(model.mesh()).centre, here = (eye - centre).normalized();
  double cosine = -1;
  for (const PosedCamera& camera : model.cameras())
    cosine = std::max(cosine, here.dot((camera_centre(camera.camera_from_object) - centre).normalized()));
  return std::acos(std::min(cosine, 1.0)) / kDegree;
}

std::string no_photograph_note(const ModelSnapshot& model, const Eigen::Vector3d& eye) {
  const double away = nearest_photograph_deg(model, eye);
  if (!(away > kFarFromPhotographsDeg)) return "";
  return format("no photograph from here: the nearest is %.0f degrees away", away);
}

}  // namespace sheen
