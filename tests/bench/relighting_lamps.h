// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/goal_rows.h"

namespace sheen {

/// Pictures of the simulated object in lamps that no image had, against exact ones: large lamps, an environment, lamps
/// off the plane.
void report_lamps(GoalReport& report);

}  // namespace sheen
