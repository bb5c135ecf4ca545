// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace sheen {

/// A quantity that rises or falls with the step, evenly in logarithms but for a little noise, is brought to what is
/// wanted by the step, from below.
class StepSearch {
 public:
  static constexpr int kMostTries = 9;
  /// No step outside of `finest` to `coarsest` is tried. `slope`: of the quantity's logarithm, about.
  StepSearch(double wanted, double slope, double first, double finest, double coarsest)
      : wanted_(wanted),
        slope_(slope),
        at_(std::log(first)),
        finest_(std::log(finest)),
        coarsest_(std::log(coarsest)) {}

  double step() const { return std::exp(at_); }
  /// What the step gave. False when no other step is worth trying.
  bool next(double found) {
    const Try here{at_, std::log(std::max(found, 1e-9) / wanted_)};
    const bool within = found <= wanted_;
    if (++tried_ == kMostTries || (within && here.beyond > -kNearEnough)) return false;
    std::optional<Try>&latest = within ? within_ : beyond_, &other = within ? beyond_ : within_;
    // On the same side as before: what is beyond on the other one counts half (the Illinois rule), or a bent line is
    // followed in ever smaller steps.
    if (other && last_within_ == within) other->beyond = kAim + (other->beyond - kAim) / 2;
    latest = here;
    last_within_ = within;
    at_ = other ? between() : further(here);
    return other ? std::abs(other->at - here.at) > kSameStep : at_ != here.at;
  }

 private:
  /// In logarithms: a step, and how far what it gave is beyond what is wanted.
  struct Try {
    double at, beyond;
  };
  static constexpr double kNearEnough = 0.015, kAim = -kNearEnough / 2, kSameStep = 0.008, kFarthest = 1.5;

  /// Where a straight line would have it.
  double between() const {
    const double fraction = (kAim - within_->beyond) / (beyond_->beyond - within_->beyond);
    return within_->at + std::clamp(fraction, 0.02, 0.98) * (beyond_->at - within_->at);
  }
  double further(const Try& here) const {
    const double move = (kAim - here.beyond) / slope_;
    return std::clamp(here.at + std::clamp(move, -kFarthest, kFarthest), finest_, coarsest_);
  }

  double wanted_, slope_, at_, finest_, coarsest_;
  std::optional<Try> within_, beyond_;  ///< the latest on each side
  std::optional<bool> last_within_;
  int tried_ = 0;
};

}  // namespace sheen
