// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_storing.h"

#include "common/base/clock.h"

namespace sheen {

std::optional<std::uint64_t> store_capture(Session& session, TrackerLinks& links, TrackerLinks::Arrival& arrival,
                                           const std::stop_token& stop) {
  Capture& capture = arrival.received.capture;
  capture.times.received_ns = steady_now_ns();
  try {
    const std::uint64_t index = patiently(stop, [&] { return session.append(capture); });
    links.acknowledge(arrival);
    return index;
  } catch (const TakenName& error) {
    log_error("session", error.what(), {{"endpoint", links.endpoint(arrival.tracker)}});
    links.refuse(arrival, error.what());
    return std::nullopt;
  }
}

}  // namespace sheen
