// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/goal_rows.h"

namespace sheen {

/// The spacing of lights for a tolerance of 16 grey levels: what ten million random elements are off by.
void report_bound(GoalReport& report);

}  // namespace sheen
