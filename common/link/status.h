// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace sheen {

enum class SourceState : std::uint8_t {
  kUnspecified = 0,
  kStarting = 1,
  kLive = 2,
  kStale = 3,  ///< frames have stopped coming
  kEnded = 4,
};
const char* to_string(SourceState state);

/// What a daemon publishes for people who watch.
struct Status {
  std::string role;  ///< "tracker", "reconstructor"
  std::string source_session;
  std::uint64_t sequence = 0;  ///< of the status messages; set by the publisher
  std::int64_t clock_ns = 0;   ///< publisher's steady clock
  SourceState state = SourceState::kUnspecified;
  std::string message;                   ///< one line for a person
  std::map<std::string, double> gauges;  ///< counters and readings by name, SI units
  std::vector<std::uint8_t> preview_jpeg;
};

}  // namespace sheen
