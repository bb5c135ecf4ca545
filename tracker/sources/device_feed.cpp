// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/device_feed.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "common/base/guarded_thread.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kWaiting = 8;  ///< frames that nobody has taken yet
constexpr milliseconds kStale{150};  ///< without a frame; more where the frame period is long
constexpr double kStalePeriods = 1.8;
constexpr milliseconds kRetry{100};       ///< between attempts to open the device
constexpr milliseconds kCloseBound{500};  ///< for the worker to end

}  // namespace

/// What the worker and the feed have in common. The worker may outlive the feed: it hangs in a call of a driver.
struct DeviceFeed::Shared {
  const OpenDevice open;
  mutable std::mutex mutex;  // guards everything below
  mutable std::condition_variable changed;
  std::deque<Frame> waiting;
  bool started = false, stopping = false, closed = false;
  Clock::time_point last_sign;  ///< start or latest frame
  double frame_rate_hz = 0;
  std::uint64_t read = 0;  ///< frames, also those that were dropped
  SourceStats stats;
  std::string trouble;

  explicit Shared(OpenDevice how) : open(std::move(how)) {}
  bool stopped_while(milliseconds pause) const;
  void put(Frame frame);
  std::unique_ptr<DeviceConnection> reopened();
  void run(std::unique_ptr<DeviceConnection> device);
  void end(const std::string& why);
};

bool DeviceFeed::Shared::stopped_while(milliseconds pause) const {
  std::unique_lock lock(mutex);
  return changed.wait_for(lock, pause, [this] { return stopping; });
}

void DeviceFeed::Shared::put(Frame frame) {
  const std::lock_guard lock(mutex);
  frame.camera_frame_id = read++;
  last_sign = Clock::now();
  if (waiting.size() == kWaiting) {
    waiting.pop_front();
    ++stats.missed;
    ++stats.underruns;
  }
  waiting.push_back(std::move(frame));
  changed.notify_all();
}

/// Tries until the device is back; null when it is told to stop.
std::unique_ptr<DeviceConnection> DeviceFeed::Shared::reopened() {
  while (!stopped_while(kRetry)) {
    try {
      auto device = open();
      const std::lock_guard lock(mutex);
      ++stats.reopened;
      trouble.clear();
      frame_rate_hz = device->frame_rate_hz();
      return device;
    } catch (...) {
      const std::lock_guard lock(mutex);
      trouble = words_of(std::current_exception());
    }
  }
  return nullptr;
}

void DeviceFeed::Shared::run(std::unique_ptr<DeviceConnection> device) {
  {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return started || stopping; });
  }
  while (device && !stopped_while(milliseconds(0))) {
    bool there = false;
    const auto read_one = [&] {
      std::optional<Frame> frame = device->read();
      there = frame.has_value();
      if (there) put(*std::move(frame));
    };
    guarded(read_one, [](const std::exception_ptr&) {});  // it is gone, or beyond us: `reopened` tells
    if (there) continue;
    device.reset();
    device = reopened();
  }
  device.reset();
  end({});
}

void DeviceFeed::Shared::end(const std::string& why) {
  const std::lock_guard lock(mutex);
  trouble = why;
  closed = true;
  changed.notify_all();
}

DeviceFeed::DeviceFeed(OpenDevice open) : shared_(std::make_shared<Shared>(std::move(open))) {
  std::unique_ptr<DeviceConnection> device = shared_->open();
  shared_->frame_rate_hz = device->frame_rate_hz();
  detached_thread([shared = shared_, device = std::move(device)]() mutable { shared->run(std::move(device)); },
                  [shared = shared_](const std::exception_ptr& error) { shared->end(words_of(error)); });
}

DeviceFeed::~DeviceFeed() {
  std::unique_lock lock(shared_->mutex);
  shared_->stopping = true;
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, kCloseBound, [this] { return shared_->closed; });
}

std::optional<Frame> DeviceFeed::next(milliseconds timeout) {
  std::unique_lock lock(shared_->mutex);
  if (!shared_->started) {
    shared_->started = true;
    shared_->last_sign = Clock::now();
    shared_->changed.notify_all();
  }
  if (!shared_->changed.wait_for(lock, timeout, [this] { return !shared_->waiting.empty(); })) return std::nullopt;
  Frame frame = std::move(shared_->waiting.front());
  shared_->waiting.pop_front();
  SourceStats& stats = shared_->stats;
  if (stats.frames++ == 0) stats.first_frame_id = frame.camera_frame_id;
  stats.last_frame_id = frame.camera_frame_id;
  return frame;
}

SourceState DeviceFeed::state() const {
  const std::lock_guard lock(shared_->mutex);
  if (!shared_->started) return SourceState::kStarting;
  const double rate = shared_->frame_rate_hz;
  const milliseconds stale =
      rate > 0 ? std::max(kStale, milliseconds(static_cast<int>(kStalePeriods * 1000 / rate))) : kStale;
  if (Clock::now() - shared_->last_sign > stale) return SourceState::kStale;
  return shared_->read > 0 ? SourceState::kLive : SourceState::kStarting;
}

SourceStats DeviceFeed::stats() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->stats;
}

std::string DeviceFeed::trouble() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->trouble;
}

}  // namespace sheen
