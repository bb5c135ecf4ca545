// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/effort/tradeoff_wish.h"

namespace sheen {

/// "0.01" or "40dB" (the same): Frobenius norm of what a ring may lose, relative to that of its columns. Throws
/// ConfigError naming --tolerance and what it takes.
double parse_tolerance(const std::string& word);
/// The relative error of so many decibels below the signal.
double tolerance_of(double decibels);

/// A rung as `tradeoff` measured it on a scene.
struct MeasuredRung {
  double image_ms = 0;
  double psnr_db = 0;  ///< of held-out views
};
/// All rungs in their order, or none.
using MeasuredLadder = std::vector<MeasuredRung>;
/// No rung that loses more against the first is taken for its time: a share of the rings loses less.
inline constexpr double kMostLoss_dB = 0.2;
/// Of the budget, when a rung is chosen: later images cost a little more than those it is chosen by.
inline constexpr double kBudgetMargin = 0.9;
/// The first rung, `in_use` or a coarser one, that keeps the budget, when the one in use takes `image_ms`; where none
/// does, the last one that loses little enough. `ladder` must not be empty.
int rung_within(const MeasuredLadder& ladder, double image_ms, int in_use, double budget_ms);
/// The cheapest rung that reaches a PSNR; 0 when none does.
int rung_reaching(const MeasuredLadder& ladder, double psnr_db);

/// Brings the time of an image towards a budget: a rung for the whole capture, chosen by the first images; after that
/// the share of rings that an image updates. It follows a few images later: single images may take longer, and where
/// the least share still takes too long, all do. What was decided is recorded, so that the model is a function of the
/// captures, their numbers and the record: with the record of an earlier run, the same captures give the same bits.
class EffortControl {
 public:
  static constexpr std::uint64_t kProbeImages = 8;  ///< updates that are timed before the rung is chosen

  EffortControl(double image_ms, int levels) : budget_ms_(image_ms), levels_(levels) {}
  /// Goes on from the record of an earlier run, in which `captures` had come. Throws ConfigError when it is no record.
  EffortControl(double image_ms, int levels, const std::string& record, std::uint64_t captures);

  double budget_ms() const { return budget_ms_; }
  std::optional<int> rung() const { return rung_; }  ///< nothing until it is chosen
  void set_rung(int rung) { rung_ = rung; }

  /// Share of the rings that capture number `capture` may update.
  double share(std::uint64_t capture) const;
  /// The update of a capture took so long: decides for the captures after it, unless the record speaks of them.
  void observe(std::uint64_t capture, double update_ms);
  /// The captures come again from the first: so many of them are to be treated as they were, if a rung was chosen.
  void begin_again(std::uint64_t captures);

  std::string record() const;

 private:
  void set_level(std::uint64_t from, int level);

  double budget_ms_;
  int levels_;  ///< that the model has
  std::optional<int> rung_;
  std::map<std::uint64_t, int> level_from_;  ///< a capture: from it on, which share
  std::uint64_t recorded_ = 0;
  double sum_ms_ = 0;
  int timed_ = 0;
};

}  // namespace sheen
