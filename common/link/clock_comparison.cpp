// SPDX-License-Identifier: Apache-2.0
#include "common/link/clock_comparison.h"

#include <algorithm>

namespace sheen {

void ClockComparison::add(std::int64_t asked_ns, std::int64_t theirs_ns, std::int64_t answered_ns) {
  const std::int64_t round_trip_ns = answered_ns - asked_ns;
  // A peer may say any time at all: the difference wraps rather than overflows.
  const auto offset_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(theirs_ns) -
                                                   static_cast<std::uint64_t>(asked_ns + round_trip_ns / 2));
  latest_.push_back({offset_ns, round_trip_ns});
  if (latest_.size() > kKept) latest_.pop_front();
}

std::optional<ClockOffset> ClockComparison::best() const {
  const auto best = std::min_element(latest_.begin(), latest_.end(), [](const ClockOffset& a, const ClockOffset& b) {
    return a.round_trip_ns < b.round_trip_ns;
  });
  if (best == latest_.end()) return std::nullopt;
  return *best;
}

}  // namespace sheen
