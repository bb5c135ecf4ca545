// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/registration/image_registration.h"
#include "tracker/calibration/point_registration.h"

namespace sheen {

/// A mesh on the stage, and what it rests on.
struct Registration {
  Placement placement;
  bool free_scale = false;
  std::optional<PointRegistration> points;
  std::optional<ImageRegistration> images;
  std::string undone;                 ///< what the mesh's frame was corrected by before; empty: nothing
  std::string not_found;              ///< why the mesh does not stand there after all; empty: it does
  std::vector<std::string> warnings;  ///< of both, and of how they agree
};

std::string registration_text(const Registration& registration);
std::string registration_json(const Registration& registration);

}  // namespace sheen
