// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/choice_schedule.h"

#include <cmath>

namespace sheen {

int ChoiceSchedule::due_after(int images) const {
  constexpr double kChoiceGrowth = 1.4, kLateChoiceGrowth = 2;
  constexpr double kLateChoice = 32;  // images; a choice costs the cube of its views, and changes less and less
  constexpr double kGoldenRatio = 0.6180339887498949;
  if (images < kFirstChoice) return kFirstChoice;
  const double phase = phase_ * kGoldenRatio - std::floor(phase_ * kGoldenRatio);  // 0..1
  double due = kFirstChoice * std::pow(kChoiceGrowth, phase);
  while (std::ceil(due) <= images) due *= due < kLateChoice ? kChoiceGrowth : kLateChoiceGrowth;
  return static_cast<int>(std::ceil(due));
}

}  // namespace sheen
