// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of a capture on this machine: `deploy/measure capture [--json FILE]`. Hostile messages and a
// million mutations are `tests/loopback/attack`; two hosts whose clocks differ are a test.
#include "tests/bench/capture_link.h"
#include "tests/bench/capture_pose.h"

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of a capture: poses, the link, faults.",
                              [](sheen::GoalReport& report) {
                                sheen::measure_poses(report);
                                sheen::measure_link(report);
                              });
}
