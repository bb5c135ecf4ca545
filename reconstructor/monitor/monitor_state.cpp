// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_state.h"

#include <algorithm>

namespace sheen {

DurationSummary summarize(const RunningStatistics& statistics) {
  if (statistics.count() == 0) return {};
  return {.count = statistics.count(),
          .sum_s = statistics.sum_s(),
          .p50_s = statistics.quantile_s(0.5),
          .p95_s = statistics.quantile_s(0.95),
          .p99_s = statistics.quantile_s(0.99)};
}

const char* to_string(CaptureState state) {
  switch (state) {
    case CaptureState::kWaiting:
      return "waiting";
    case CaptureState::kLive:
      return "live";
    case CaptureState::kStale:
      return "stale";
    case CaptureState::kDisconnected:
      return "disconnected";
    case CaptureState::kEnded:
      return "ended";
    case CaptureState::kFinishing:
      return "finishing";
    case CaptureState::kRefining:
      return "refining";
    case CaptureState::kSaving:
      return "saving";
    case CaptureState::kJudging:
      return "judging";
    case CaptureState::kFailed:
      return "failed";
    case CaptureState::kStalled:
      break;
  }
  return "stalled";
}

CaptureState capture_state(const MonitorState& state, MonitorState::Clock::time_point published,
                           MonitorState::Clock::time_point now) {
  if (!state.error.empty()) return CaptureState::kFailed;
  if (now - published > kStaleAfter) return CaptureState::kStalled;
  if (state.ending) return state.ending->state;
  if (state.ended) return CaptureState::kEnded;
  if (std::any_of(state.links.begin(), state.links.end(),
                  [](const auto& link) { return link.came && !link.connected && !link.ended; }))
    return CaptureState::kDisconnected;
  if (!state.last_frame) return CaptureState::kWaiting;
  return now - *state.last_frame > kStaleAfter ? CaptureState::kStale : CaptureState::kLive;
}

}  // namespace sheen
