// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/tracker_links.h"

#include <algorithm>
#include <utility>

#include "common/base/errors.h"

namespace sheen {
namespace {

/// What moves on either side moves; what nobody knows of one side stays unknown.
Motion joined(Motion a, Motion b) {
  if (a == Motion::kMoves || b == Motion::kMoves) return Motion::kMoves;
  return a == b ? a : Motion::kUnspecified;
}

void add(TrackerFrames& sum, const TrackerFrames& frames) {
  sum.judged += frames.judged;
  for (const auto& [reason, count] : frames.refused) sum.refused[reason] += count;
}

void append(std::string& all, const std::string& endpoint, const std::string& text) {
  if (!text.empty()) all += (all.empty() ? "" : "; ") + endpoint + ": " + text;
}

}  // namespace

ReceiverStats joined(const std::vector<LinkState>& links) {
  if (links.empty()) return {};
  if (links.size() == 1) return links.front().stats;
  ReceiverStats sum;
  sum.ended = true;
  sum.motion = {Motion::kMoves, links.front().stats.motion.light};
  for (const auto& [endpoint, link] : links) {
    sum.kept += link.kept;
    sum.live += link.live;
    sum.duplicates += link.duplicates;
    sum.rejected_messages += link.rejected_messages;
    sum.bytes += link.bytes;
    sum.missing += link.missing;
    for (const auto& [reason, count] : link.rejected_by_reason) sum.rejected_by_reason[reason] += count;
    add(sum.tracker, link.tracker);
    if (link.connected && !link.ended) append(sum.tracker.trouble, endpoint, link.tracker.trouble);
    sum.motion.light = joined(sum.motion.light, link.motion.light);
    sum.connected |= link.connected;
    sum.came |= link.came;
    sum.ended &= link.ended;
    append(sum.source_failure, endpoint, link.source_failure);
    const bool gone = link.came && !link.connected && !link.ended && link.last_error.empty();
    append(sum.last_error, endpoint, gone ? "the tracker is gone" : link.last_error);
  }
  return sum;
}

TrackerLinks::TrackerLinks(const std::vector<ReceiverOptions>& trackers) {
  for (ReceiverOptions options : trackers) {
    if (std::ranges::find(endpoints_, options.endpoint) != endpoints_.end())
      throw ConfigError("the endpoint " + options.endpoint + " is given twice; each tracker has its own");
    endpoints_.push_back(options.endpoint);
    options.on_arrival = [this] {
      const std::lock_guard lock(mutex_);
      ++arrivals_;
      arrived_.notify_one();
    };
    receivers_.push_back(std::make_unique<CaptureReceiver>(options));
  }
}

std::optional<TrackerLinks::Arrival> TrackerLinks::next(std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    std::unique_lock lock(mutex_);
    const std::uint64_t seen = arrivals_;
    lock.unlock();
    for (std::size_t k = 0; k < receivers_.size(); ++k) {
      const std::size_t i = (turn_ + k) % receivers_.size();
      std::optional<Received> received = receivers_[i]->next(std::chrono::milliseconds(0));
      if (!received) continue;
      turn_ = i + 1;
      return Arrival{*std::move(received), i};
    }
    lock.lock();
    if (!arrived_.wait_until(lock, deadline, [&] { return arrivals_ != seen; })) return std::nullopt;
  }
}

void TrackerLinks::acknowledge(const Arrival& arrival) {
  const Capture& capture = arrival.received.capture;
  receivers_.at(arrival.tracker)->acknowledge(capture.source_session, capture.sequence);
}

void TrackerLinks::refuse(const Arrival& arrival, const std::string& reason) {
  receivers_.at(arrival.tracker)->refuse(arrival.received.capture.source_session, reason);
}

std::vector<LinkState> TrackerLinks::states() const {
  std::vector<LinkState> states;
  for (std::size_t i = 0; i < receivers_.size(); ++i) states.push_back({endpoints_[i], receivers_[i]->stats()});
  return states;
}

}  // namespace sheen
