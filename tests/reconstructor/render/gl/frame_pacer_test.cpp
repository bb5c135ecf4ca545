// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/frame_pacer.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

/// A machine on which a frame takes a fixed time, and one for each pixel, several times as long for several samples.
struct Machine {
  double fixed_ms, full_ms;
  double takes(const MovingFrame& frame) const {
    return fixed_ms + full_ms * (frame.smooth ? 1 : 0.4) / (frame.pixel * frame.pixel);
  }
  double takes_at_rest() const { return takes({}); }
};

void open(FramePacer& pacer, const Machine& machine) {
  pacer.moved(machine.takes(pacer.frame()));
  pacer.rested(machine.takes_at_rest());
}

/// Frames of a movement; true when none was finer than the one before.
bool drag(FramePacer& pacer, const Machine& machine, int frames) {
  bool never_finer = true;
  for (int i = 0; i < frames; ++i) {
    const MovingFrame before = pacer.frame();
    pacer.moved(machine.takes(before));
    never_finer &= pacer.frame().pixel >= before.pixel && pacer.frame().smooth <= before.smooth;
  }
  return never_finer;
}

TEST(FramePacer, AFastMachineDrawsNothingCoarse) {
  const Machine machine{1, 8};
  FramePacer pacer;
  open(pacer, machine);
  for (int movement = 0; movement < 3; ++movement) {
    EXPECT_TRUE(drag(pacer, machine, 50));
    EXPECT_TRUE(pacer.finest());
    pacer.rested(machine.takes_at_rest());
  }
}

TEST(FramePacer, OnSlowMachinesFramesComeInTimeAndAsFineAsTimeAllows) {
  for (const double full : {60.0, 120.0, 300.0, 700.0}) {
    const Machine machine{8, full};
    FramePacer pacer;
    open(pacer, machine);
    EXPECT_TRUE(drag(pacer, machine, 20)) << full;
    EXPECT_LE(machine.takes(pacer.frame()), FramePacer::kLimitMs) << full;
    // Where it could have been finer, the next movement is.
    for (int movement = 0; movement < 5; ++movement) {
      pacer.rested(machine.takes_at_rest());
      drag(pacer, machine, 20);
    }
    EXPECT_GT(machine.takes(pacer.frame()), 0.3 * FramePacer::kGoalMs) << full;
    EXPECT_LE(machine.takes(pacer.frame()), FramePacer::kLimitMs) << full;
  }
}

TEST(FramePacer, OneSlowFrameIsAnAccidentAndManyAreNot) {
  const Machine machine{5, 100};
  FramePacer pacer;
  open(pacer, machine);
  drag(pacer, machine, 10);
  const double pixel = pacer.frame().pixel;
  pacer.moved(300);
  drag(pacer, machine, 10);
  EXPECT_EQ(pacer.frame().pixel, pixel);
  drag(pacer, {150, 100}, 20);  // others need the processor
  EXPECT_GT(pacer.frame().pixel, pixel);
  for (int movement = 0; movement < 3; ++movement) {
    drag(pacer, machine, 20);
    pacer.rested(machine.takes_at_rest());
  }
  EXPECT_LE(pacer.frame().pixel, pixel + 0.5) << "and back, between two movements";
}

TEST(FramePacer, ALevelIsKeptFromOneMovementToTheNext) {
  const Machine machine{5, 160};
  FramePacer pacer;
  open(pacer, machine);
  for (int movement = 0; movement < 20; ++movement) {
    drag(pacer, machine, 10);
    const double pixel = pacer.frame().pixel;
    pacer.rested(machine.takes_at_rest());
    if (movement > 2) {
      EXPECT_EQ(pacer.frame().pixel, pixel) << "it does not swing";
    }
  }
}

}  // namespace
}  // namespace sheen
