// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of the online factorization on this machine: `deploy/measure numerics [--json FILE]`, about four
// minutes. Patches of 2,448 rows seen from 300 directions (tests/support/test_patches.h); beside each figure that of
// the batch SVD and of a plain Brand update, from the same run. docs/numerics.md says what the rows mean.
#include "tests/bench/numerics_rows.h"

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of the online factorization on this machine.",
                              [](sheen::GoalReport& report) {
                                sheen::measure_speed(report);
                                sheen::measure_accuracy(report);
                                sheen::measure_missing(report);
                                sheen::measure_history(report);
                              });
}
