// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace sheen {

/// Quantiles of durations in bounded memory, however many there are: counts in buckets that are 2 % wide, between 1 us
/// and about 20 min. A quantile is right to 1 % of its value; count, sum, least and greatest are exact. Not
/// synchronised.
class RunningStatistics {
 public:
  RunningStatistics();

  /// Negative durations (clocks of two hosts that disagree) count as 0; NaN is ignored.
  void add(double seconds);

  std::uint64_t count() const { return count_; }
  double sum_s() const { return sum_; }
  double min_s() const;  ///< NaN when empty, as below
  double max_s() const;
  double quantile_s(double q) const;  ///< q in [0, 1]; 0.5 is the median (the lower one of two)
  double median_s() const { return quantile_s(0.5); }

 private:
  std::vector<std::uint64_t> buckets_;
  std::uint64_t count_ = 0;
  double sum_ = 0, min_ = 0, max_ = 0;
};

}  // namespace sheen
