// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/simulation/simulated_rig.h"

namespace sheen::testing {

/// A rig that is quick to render: small pictures of a sphere in coarse light.
inline SimulationOptions sphere_rig(int frames) {
  SimulationOptions options;
  options.object = "sphere";
  options.frames = frames;
  options.width = 480;
  options.height = 360;
  options.bake = {
      .sky_directions = 64, .bounce_directions = 32, .bounces = 1, .area_light_samples = 2, .stage_cell_m = 0.02f};
  return options;
}

}  // namespace sheen::testing
