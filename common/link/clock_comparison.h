// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace sheen {

/// How another machine's steady clock stands to this one's.
struct ClockOffset {
  std::int64_t offset_ns = 0;      ///< theirs minus ours
  std::int64_t round_trip_ns = 0;  ///< of the question it comes from; the offset is right to half of it
};

/// Compares two clocks by questions and answers. Of the latest ones, that with the shortest round trip counts: it
/// waited least behind other data, and clocks drift apart too slowly to matter within so few.
class ClockComparison {
 public:
  /// A question asked and its answer had at these times of our clock, answered at `theirs_ns` of theirs.
  void add(std::int64_t asked_ns, std::int64_t theirs_ns, std::int64_t answered_ns);
  void forget() { latest_.clear(); }
  std::optional<ClockOffset> best() const;

 private:
  static constexpr std::size_t kKept = 8;
  std::deque<ClockOffset> latest_;
};

}  // namespace sheen
