// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/effort/limits.h"

namespace sheen {

/// "0.01" or "40dB" (the same): Frobenius norm of what a part of the surface may lose, relative to that of its columns.
/// Throws ConfigError naming --tolerance and what it takes.
double parse_tolerance(const std::string& word);
/// The relative error of so many decibels below the signal.
double tolerance_of(double decibels);

/// An effort level as `tradeoff` measured it on a scene.
struct MeasuredLevel {
  double image_ms = 0;
  double psnr_db = 0;  ///< of held-out views
};
/// All effort levels in their order, or none.
using MeasuredLevels = std::vector<MeasuredLevel>;
/// No effort level that loses more against the first is taken for its time: updating less of each image loses less.
inline constexpr double kMostLoss_dB = 0.2;
/// Of the budget, when an effort level is chosen: later images cost a little more than those it is chosen by.
inline constexpr double kBudgetMargin = 0.9;
/// The first effort level, `in_use` or a coarser one, that keeps the budget, when the one in use takes `image_ms`;
/// where none does, the last one that loses little enough. `measured` must not be empty.
int level_within(const MeasuredLevels& measured, double image_ms, int in_use, double budget_ms);
/// The cheapest effort level that reaches a PSNR; 0 when none does.
int level_reaching(const MeasuredLevels& measured, double psnr_db);

/// Brings the time of an image towards a budget: an effort level for the whole capture, chosen by the first images;
/// after that the fraction of what an image shows that it updates. It follows a few images later: single images may
/// take longer, and where the smallest fraction still takes too long, all do. What was decided is recorded, so that the
/// model is a function of the captures, their numbers and the record: with the record of an earlier run, the same
/// captures give the same bits.
class EffortControl {
 public:
  static constexpr std::uint64_t kProbeImages = 8;  ///< updates that are timed before the effort level is chosen

  EffortControl(double image_ms, int levels) : budget_ms_(image_ms), levels_(levels) {}
  /// Goes on from the record of an earlier run, in which `captures` had come. Throws ConfigError when it is no record.
  EffortControl(double image_ms, int levels, const std::string& record, std::uint64_t captures);

  double budget_ms() const { return budget_ms_; }
  std::optional<int> effort_level() const { return level_; }  ///< nothing until it is chosen
  void set_level(int level) { level_ = level; }

  /// Fraction of the patches that capture number `capture` may update.
  double update_fraction(std::uint64_t capture) const;
  /// The update of a capture took so long: decides for the captures after it, unless the record speaks of them.
  void observe(std::uint64_t capture, double update_ms);
  /// The captures come again from the first: so many of them are to be treated as they were, if an effort level was
  /// chosen.
  void begin_again(std::uint64_t captures);

  std::string record() const;

 private:
  void set_step(std::uint64_t from, int step);

  double budget_ms_;
  int levels_;  ///< that the model has
  std::optional<int> level_;
  std::map<std::uint64_t, int> step_from_;  ///< a capture: from it on, which step
  std::uint64_t recorded_ = 0;
  double sum_ms_ = 0;
  int timed_ = 0;
};

}  // namespace sheen
