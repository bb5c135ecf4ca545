// SPDX-License-Identifier: Apache-2.0
#include "common/base/running_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sheen {
namespace {

constexpr double kFirst = 1e-6;  // s, upper edge of the first bucket
constexpr double kRatio = 1.02;
constexpr std::size_t kBuckets = 1060;  // kFirst * kRatio^1060: 22 min

std::size_t bucket_of(double seconds) {
  if (seconds <= kFirst) return 0;
  const double steps = std::ceil(std::log(seconds / kFirst) / std::log(kRatio));
  return std::min(kBuckets - 1, static_cast<std::size_t>(std::min(steps, static_cast<double>(kBuckets))));
}

}  // namespace

RunningStatistics::RunningStatistics() : buckets_(kBuckets, 0) {}

void RunningStatistics::add(double seconds) {
  if (std::isnan(seconds)) return;
  seconds = std::clamp(seconds, 0.0, std::numeric_limits<double>::max());
  min_ = count_ == 0 ? seconds : std::min(min_, seconds);
  max_ = count_ == 0 ? seconds : std::max(max_, seconds);
  sum_ += seconds;
  ++count_;
  ++buckets_[bucket_of(seconds)];
}

double RunningStatistics::min_s() const {
  return count_ > 0 ? min_ : std::numeric_limits<double>::quiet_NaN();
}

double RunningStatistics::max_s() const {
  return count_ > 0 ? max_ : std::numeric_limits<double>::quiet_NaN();
}

double RunningStatistics::quantile_s(double q) const {
  if (count_ == 0) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::uint64_t>(std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_)));
  std::uint64_t below = 0;
  std::size_t bucket = 0;
  while (bucket + 1 < kBuckets && (below += buckets_[bucket]) < std::max<std::uint64_t>(rank, 1)) ++bucket;
  if (bucket == 0) return min_;
  if (bucket == kBuckets - 1) return max_;
  const double middle = kFirst * std::pow(kRatio, static_cast<double>(bucket) - 0.5);
  return std::clamp(middle, min_, max_);
}

}  // namespace sheen
