// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "tests/bench/goal_rows.h"

namespace sheen {

/// Captures of the simulated rig, 1024x768, of whose object `serve` is told no mesh; beside them one with the true
/// mesh. What they leave goes to a folder.
void measure_live_shape(GoalReport& report, const std::filesystem::path& folder);

}  // namespace sheen
