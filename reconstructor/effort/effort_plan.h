// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "reconstructor/effort/effort_control.h"
#include "reconstructor/effort/limits.h"

namespace sheen {

/// At which effort level a model works, and why: three things ask for a level, and the coarsest of them holds.
class EffortPlan {
 public:
  /// `levels`: that the model has.
  explicit EffortPlan(int levels) : levels_(levels) {}

  /// `record`, of `captures` earlier ones: what an earlier run decided; empty: nothing. `measured`: what the levels
  /// cost and lose on this scene, where that is known. Throws ConfigError.
  void keep_within(const Limits& limits, const std::string& record, std::uint64_t captures, MeasuredLevels measured);
  /// No finer than this level.
  void begin_at(int level) { target_level_ = level; }
  /// The captures come again from the first: what they decided is decided again; what the time decided stays.
  void begin_again(std::uint64_t captures);

  const Limits& limits() const { return limits_; }
  const MeasuredLevels& measured() const { return measured_; }
  int levels() const { return levels_; }
  int level() const;
  void set_memory_level(int level) { memory_level_ = level; }

  /// Null without a budget of time.
  EffortControl* control() { return control_ ? &*control_ : nullptr; }
  /// Of what capture number `capture` shows, 1 without a budget.
  double update_fraction(std::uint64_t capture) const { return control_ ? control_->update_fraction(capture) : 1; }
  /// What was decided to keep the budget, for a later run to follow; empty when nothing was.
  std::string record() const { return control_ ? control_->record() : std::string(); }

 private:
  int levels_;
  Limits limits_;
  MeasuredLevels measured_;
  std::optional<EffortControl> control_;
  int target_level_ = 0;             ///< by the PSNR asked for
  std::optional<int> memory_level_;  ///< by the memory, when the first image has come
};

}  // namespace sheen
