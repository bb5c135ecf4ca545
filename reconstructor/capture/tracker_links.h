// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/link/transport.h"

namespace sheen {

/// The link to one tracker, as it is now.
struct LinkState {
  std::string endpoint;
  ReceiverStats stats;
};

/// All links as one: counts added up, connected where any is, ended where all are; what is said names the trackers
/// where there are several, which are cameras in several places. No clock: each has its own.
ReceiverStats joined(const std::vector<LinkState>& links);

/// The links to the trackers of a capture, a receiver each. What they send is told apart by source session and
/// sequence. One thread takes captures and acknowledges them; `states` is for any.
class TrackerLinks {
 public:
  /// One or more. Throws ConfigError.
  explicit TrackerLinks(const std::vector<ReceiverOptions>& trackers);

  struct Arrival {
    Received received;
    std::size_t tracker = 0;                 ///< that sent it, counted as in the constructor
    std::optional<std::uint64_t> stored_as;  ///< its index in the session, once it is there
  };
  /// The next capture of any tracker, in turns where several send; nothing after `timeout`.
  std::optional<Arrival> next(std::chrono::milliseconds timeout);
  /// Call once the capture is durable.
  void acknowledge(const Arrival& arrival);
  /// No more is taken of the arrival's source by that link, also of what waits, and its tracker is told why.
  void refuse(const Arrival& arrival, const std::string& reason);
  const std::string& endpoint(std::size_t tracker) const { return endpoints_.at(tracker); }
  std::vector<LinkState> states() const;

 private:
  std::vector<std::string> endpoints_;
  std::size_t turn_ = 0;  ///< the tracker that is asked first
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::uint64_t arrivals_ = 0;
  std::vector<std::unique_ptr<CaptureReceiver>> receivers_;  // last: they call back until they are gone
};

/// Who watches what arrives. Calls come from the thread that receives and must be quick.
struct ArrivalObserver {
  std::function<void(const std::vector<LinkState>&)> on_link;  ///< many times per second
  std::function<void(const Capture&)> on_capture;              ///< every one, live or to be kept

  void look(const std::vector<LinkState>& links, const std::optional<TrackerLinks::Arrival>& arrival) const {
    if (on_link) on_link(links);
    if (on_capture && arrival) on_capture(arrival->received.capture);
  }
};

}  // namespace sheen
