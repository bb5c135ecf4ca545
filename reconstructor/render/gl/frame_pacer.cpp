// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/frame_pacer.h"

#include <algorithm>
#include <array>

namespace sheen {
namespace {

/// From fine to coarse. Samples cost more than pixels where OpenGL draws in software.
constexpr std::array<MovingFrame, 6> kLevels{MovingFrame{1, true}, {1, false}, {1.5, false},
                                             {2, false},           {3, false}, {4, false}};
constexpr int kCoarsest = static_cast<int>(kLevels.size()) - 1;
constexpr double kFractionOfOneSample = 0.45;  // of the time of several
constexpr int kSlowFrames = 2;                 // of which one alone is an accident

double cost(int level) {
  const MovingFrame& frame = kLevels[static_cast<std::size_t>(level)];
  return (frame.smooth ? 1 : kFractionOfOneSample) / (frame.pixel * frame.pixel);
}

/// The finest level at which a frame is within the goal, when one at `level` takes `ms`. What does not shrink with the
/// number of pixels is not known: towards finer levels that is on the safe side.
int finest_within_goal(int level, double ms) {
  int finest = 0;
  while (finest < kCoarsest && ms * cost(finest) / cost(level) > FramePacer::kGoalMs) ++finest;
  return finest;
}

}  // namespace

MovingFrame FramePacer::frame() const {
  return kLevels[static_cast<std::size_t>(level_)];
}

void FramePacer::moved(double frame_ms) {
  least_ms_ = least_ms_ > 0 ? std::min(least_ms_, frame_ms) : frame_ms;
  slow_frames_ = frame_ms > kLimitMs ? slow_frames_ + 1 : 0;
  if (slow_frames_ < kSlowFrames || level_ == kCoarsest) return;
  level_ = std::max(level_ + 1, finest_within_goal(level_, frame_ms));
  slow_frames_ = 0;
  least_ms_ = 0;
}

void FramePacer::rested(double picture_ms) {
  const int by_picture = finest_within_goal(0, picture_ms);
  if (fine_ms_ == 0 || by_picture == 0)
    level_ = by_picture;
  else if (least_ms_ > 0)
    level_ = std::min(level_, finest_within_goal(level_, least_ms_));
  fine_ms_ = picture_ms;
  least_ms_ = 0;
  slow_frames_ = 0;
}

}  // namespace sheen
