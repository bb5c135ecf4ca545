// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "common/base/log.h"
#include "common/session/session.h"
#include "reconstructor/capture/tracker_links.h"

namespace sheen {

/// Does it again for as long as another program keeps the session's index locked; SessionBusy gets out once it is asked
/// to stop.
template <typename Action>
auto patiently(const std::stop_token& stop, const Action& action) {
  constexpr std::chrono::milliseconds kPause{50};
  for (bool told = false;; told = true) {
    try {
      return action();
    } catch (const SessionBusy& error) {
      if (stop.stop_requested()) throw;
      if (!told) log_warning("session", std::string("waits, nothing is lost: ") + error.what());
      std::this_thread::sleep_for(kPause);
    }
  }
}

/// Makes a capture that came durable, then acknowledges it; returns its index. Throws FileError, or SessionBusy once it
/// is asked to stop: it is then not acknowledged, and the tracker keeps it. Nothing where another source has stored
/// another image by that name: then no more is taken of this one, and its tracker is told.
std::optional<std::uint64_t> store_capture(Session& session, TrackerLinks& links, TrackerLinks::Arrival& arrival,
                                           const std::stop_token& stop);

}  // namespace sheen
