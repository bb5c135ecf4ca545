// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/goal_rows.h"

namespace sheen {

/// How exact tags and poses are, on rendered stages whose truth is known.
void measure_poses(GoalReport& report);

}  // namespace sheen
