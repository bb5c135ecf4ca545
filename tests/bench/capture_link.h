// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/goal_rows.h"

namespace sheen {

/// From a camera on 127.0.0.1 through both programs to the disk, with an encrypted link: how long it takes, how many
/// frames get lost, and how soon a capture goes on after a fault. Programs and sockets are real.
void measure_link(GoalReport& report);

}  // namespace sheen
