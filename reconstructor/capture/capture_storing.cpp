// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_storing.h"

#include "common/base/clock.h"

namespace sheen {

std::uint64_t store_capture(Session& session, CaptureReceiver& link, Capture& capture, const std::stop_token& stop) {
  capture.times.received_ns = steady_now_ns();
  const std::uint64_t index = patiently(stop, [&] { return session.append(capture); });
  link.acknowledge(capture.source_session, capture.sequence);
  return index;
}

}  // namespace sheen
