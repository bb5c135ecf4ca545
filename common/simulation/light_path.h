// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common/capture/lighting.h"

namespace sheen {

/// Where the lamp of a simulated rig is at each frame: points, in the frame of the object. `shape`:
///   dome   a rising spiral on the half sphere of radius 0.9 m round the object, 15 to 80 degrees up
///   plane  line by line over a square of 1 m, 0.9 m above the stage, to and fro
///   FILE   the positions of a list of lights (.lp), joined by straight lines and passed at an even pace from place to
///          place
/// Throws ConfigError for any other, also for a list of directions; FileError for a broken file.
std::vector<LightState> light_path(const std::string& shape, int frames);

}  // namespace sheen
