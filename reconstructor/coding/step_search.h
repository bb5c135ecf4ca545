// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace sheen {

/// A quantity that rises or falls evenly with the step, both in logarithms, is brought to what is wanted by the step,
/// from below.
class StepSearch {
 public:
  static constexpr int kMostTries = 9;
  /// No step outside of `finest` to `coarsest` is tried.
  StepSearch(double wanted, double slope, double first, double finest, double coarsest)
      : wanted_(std::log(wanted)),
        slope_(slope),
        at_(std::log(first)),
        finest_(std::log(finest)),
        coarsest_(std::log(coarsest)) {}

  double step() const { return std::exp(at_); }
  /// What the step gave. False when no other step is worth trying.
  bool next(double found) {
    const double here = std::log(std::max(found, 1e-9));
    ++tried_;
    if (here <= wanted_ && wanted_ - here < kNearEnough) return false;
    if (tried_ > 1 && std::abs(at_ - before_at_) > 1e-3) {
      const double slope = (here - before_) / (at_ - before_at_);
      if (slope * slope_ > 0)
        slope_ = std::clamp(slope, std::min(slope_ / 3, slope_ * 3), std::max(slope_ / 3, slope_ * 3));
    }
    before_ = here;
    before_at_ = at_;
    const double move = (wanted_ - kNearEnough / 2 - here) / slope_;
    at_ = std::clamp(at_ + std::clamp(move, -kFarthest, kFarthest), finest_, coarsest_);
    return tried_ < kMostTries && at_ != before_at_;
  }

 private:
  static constexpr double kNearEnough = 0.015, kFarthest = 1.5;
  double wanted_, slope_, at_, finest_, coarsest_, before_ = 0, before_at_ = 0;
  int tried_ = 0;
};

}  // namespace sheen
