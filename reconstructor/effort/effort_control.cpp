// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/effort_control.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr std::array<double, 8> kFractions{1, 0.75, 0.5, 0.35, 0.25, 0.17, 0.12, 0.08};
constexpr int kTimedBeforeLess = 3;   // images over the budget before less is done
constexpr int kTimedBeforeMore = 12;  // images with room before more is done
constexpr double kRoom = 0.65;        // of the budget: the next fraction up costs at most 1.5 times as much

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

int level_within(const MeasuredLevels& measured, double image_ms, int in_use, double budget_ms) {
  const auto at = [&](int level) { return measured[static_cast<std::size_t>(level)]; };
  int level = in_use;
  while (level + 1 < static_cast<int>(measured.size()) && at(0).psnr_db - at(level + 1).psnr_db <= kMostLoss_dB &&
         image_ms * at(level).image_ms / at(in_use).image_ms > kBudgetMargin * budget_ms)
    ++level;
  return level;
}

int level_reaching(const MeasuredLevels& measured, double psnr_db) {
  int level = static_cast<int>(measured.size()) - 1;
  while (level > 0 && measured[static_cast<std::size_t>(level)].psnr_db < psnr_db) --level;
  return std::max(level, 0);
}

EffortControl::EffortControl(double image_ms, int levels, const std::string& record, std::uint64_t captures)
    : budget_ms_(image_ms), levels_(levels), recorded_(captures) {
  std::istringstream in(record);
  int level = -1;
  bool good = static_cast<bool>(in >> level) && level >= 0 && level < levels_;
  std::uint64_t from = 0;
  int step = 0;
  char colon = 0;
  while (good && in >> from) {
    good = in >> colon >> step && colon == ':' && step >= 0 && step < static_cast<int>(kFractions.size());
    step_from_[from] = step;
  }
  if (!good || !is_record(in)) throw ConfigError("the session's record of its budget cannot be read: " + record);
  level_ = level;
}

double EffortControl::update_fraction(std::uint64_t capture) const {
  const auto after = step_from_.upper_bound(capture);
  return after == step_from_.begin() ? 1 : kFractions[static_cast<std::size_t>(std::prev(after)->second)];
}

void EffortControl::observe(std::uint64_t capture, double update_ms) {
  if (capture < recorded_) return;
  sum_ms_ += update_ms;
  ++timed_;
  const double mean_ms = sum_ms_ / timed_;
  const int step = step_from_.empty() ? 0 : step_from_.rbegin()->second;
  if (timed_ >= kTimedBeforeLess && mean_ms > budget_ms_)
    set_step(capture + 1, std::min(step + 1, static_cast<int>(kFractions.size()) - 1));
  else if (timed_ >= kTimedBeforeMore)
    set_step(capture + 1, mean_ms < kRoom * budget_ms_ ? std::max(step - 1, 0) : step);
}

void EffortControl::set_step(std::uint64_t from, int step) {
  sum_ms_ = 0;
  timed_ = 0;
  if (step != (step_from_.empty() ? 0 : step_from_.rbegin()->second)) step_from_[from] = step;
}

void EffortControl::begin_again(std::uint64_t captures) {
  if (level_) recorded_ = std::max(recorded_, captures);
  sum_ms_ = 0;
  timed_ = 0;
}

std::string EffortControl::record() const {
  if (!level_) return {};
  std::string text = std::to_string(*level_);
  for (const auto& [from, step] : step_from_) text += ' ' + std::to_string(from) + ':' + std::to_string(step);
  return text;
}

}  // namespace sheen
