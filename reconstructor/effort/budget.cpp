// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/budget.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr std::array<double, 8> kShares{1, 0.75, 0.5, 0.35, 0.25, 0.17, 0.12, 0.08};
constexpr int kTimedBeforeLess = 3;   // images over the budget before less is done
constexpr int kTimedBeforeMore = 12;  // images with room before more is done
constexpr double kRoom = 0.65;        // of the budget: the next share up costs at most 1.5 times as much

bool is_record(std::istream& in) {
  return in.eof() || (in >> std::ws).eof();
}

}  // namespace

double tolerance_of(double decibels) {
  return std::pow(10.0, -decibels / 20);
}

double parse_tolerance(const std::string& word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const std::string unit(end, word.data() + word.size());
  if (error == std::errc{} && unit == "dB" && value > 0 && value <= 200) return tolerance_of(value);
  if (error != std::errc{} || !unit.empty() || !(value >= 0) || !(value < 1))
    throw ConfigError("--tolerance " + word +
                      ": takes a relative error in [0, 1), such as 0.01, or decibels, such as 40dB");
  return value;
}

int rung_within(const MeasuredLadder& ladder, double image_ms, int in_use, double budget_ms) {
  const auto at = [&](int rung) { return ladder[static_cast<std::size_t>(rung)]; };
  int rung = in_use;
  while (rung + 1 < static_cast<int>(ladder.size()) && at(0).psnr_db - at(rung + 1).psnr_db <= kMostLoss_dB &&
         image_ms * at(rung).image_ms / at(in_use).image_ms > kBudgetMargin * budget_ms)
    ++rung;
  return rung;
}

int rung_reaching(const MeasuredLadder& ladder, double psnr_db) {
  int rung = static_cast<int>(ladder.size()) - 1;
  while (rung > 0 && ladder[static_cast<std::size_t>(rung)].psnr_db < psnr_db) --rung;
  return std::max(rung, 0);
}

EffortControl::EffortControl(double image_ms, int levels, const std::string& record, std::uint64_t captures)
    : budget_ms_(image_ms), levels_(levels), recorded_(captures) {
  std::istringstream in(record);
  int rung = -1;
  bool good = static_cast<bool>(in >> rung) && rung >= 0 && rung < levels_;
  std::uint64_t from = 0;
  int level = 0;
  char colon = 0;
  while (good && in >> from) {
    good = in >> colon >> level && colon == ':' && level >= 0 && level < static_cast<int>(kShares.size());
    level_from_[from] = level;
  }
  if (!good || !is_record(in)) throw ConfigError("the session's record of its budget cannot be read: " + record);
  rung_ = rung;
}

double EffortControl::share(std::uint64_t capture) const {
  const auto after = level_from_.upper_bound(capture);
  return after == level_from_.begin() ? 1 : kShares[static_cast<std::size_t>(std::prev(after)->second)];
}

void EffortControl::observe(std::uint64_t capture, double update_ms) {
  if (capture < recorded_) return;
  sum_ms_ += update_ms;
  ++timed_;
  const double mean_ms = sum_ms_ / timed_;
  const int level = level_from_.empty() ? 0 : level_from_.rbegin()->second;
  if (timed_ >= kTimedBeforeLess && mean_ms > budget_ms_)
    set_level(capture + 1, std::min(level + 1, static_cast<int>(kShares.size()) - 1));
  else if (timed_ >= kTimedBeforeMore)
    set_level(capture + 1, mean_ms < kRoom * budget_ms_ ? std::max(level - 1, 0) : level);
}

void EffortControl::set_level(std::uint64_t from, int level) {
  sum_ms_ = 0;
  timed_ = 0;
  if (level != (level_from_.empty() ? 0 : level_from_.rbegin()->second)) level_from_[from] = level;
}

void EffortControl::begin_again(std::uint64_t captures) {
  if (rung_) recorded_ = std::max(recorded_, captures);
  sum_ms_ = 0;
  timed_ = 0;
}

std::string EffortControl::record() const {
  if (!rung_) return {};
  std::string text = std::to_string(*rung_);
  for (const auto& [from, level] : level_from_) text += ' ' + std::to_string(from) + ':' + std::to_string(level);
  return text;
}

}  // namespace sheen
