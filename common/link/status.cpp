// SPDX-License-Identifier: Apache-2.0
#include "common/link/status.h"

namespace sheen {

const char* to_string(SourceState state) {
  switch (state) {
    case SourceState::kStarting:
      return "starting";
    case SourceState::kLive:
      return "live";
    case SourceState::kStale:
      return "stale";
    case SourceState::kEnded:
      return "ended";
    case SourceState::kUnspecified:
      break;
  }
  return "unspecified";
}

}  // namespace sheen
