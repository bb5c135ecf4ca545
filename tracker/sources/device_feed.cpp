// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/device_feed.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "common/base/format.h"
#include "common/base/guarded_thread.h"
#include "common/base/log.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kStale{150};  ///< without a frame; more where the frame period is long
constexpr double kStalePeriods = 1.8;
constexpr milliseconds kFirstPause{100};    ///< between attempts to open the device
constexpr std::chrono::seconds kSteady{2};  ///< a device that delivered for so long is opened again at once
constexpr milliseconds kCloseBound{500};    ///< for the worker to end

}  // namespace

/// What the worker and the feed have in common. The worker may outlive the feed: it hangs in a call of a driver.
struct DeviceFeed::Shared {
  const OpenDevice open;
  const FeedOptions options;
  mutable std::mutex mutex;  // guards everything below
  mutable std::condition_variable changed;
  std::deque<Frame> waiting;
  bool started = false, stopping = false, closed = false;
  Clock::time_point last_sign;  ///< start or latest frame
  double frame_rate_hz = 0;
  std::uint64_t read = 0;       ///< frames, also those that were dropped
  std::uint64_t overtaken = 0;  ///< of these, in the open device
  SourceStats stats;
  std::string trouble;

  Shared(OpenDevice how, FeedOptions o) : open(std::move(how)), options(std::move(o)) {}
  bool stopped_while(milliseconds pause) const;
  void put(Frame frame, std::uint64_t overtaken_so_far);
  void read_all(DeviceConnection& device);
  std::unique_ptr<DeviceConnection> reopened(milliseconds& pause);
  void run(std::unique_ptr<DeviceConnection> device);
  void tell_gone() const;
  void tell_back(Clock::duration after) const;
  void end(const std::string& why);
};

bool DeviceFeed::Shared::stopped_while(milliseconds pause) const {
  std::unique_lock lock(mutex);
  return changed.wait_for(lock, pause, [this] { return stopping; });
}

void DeviceFeed::Shared::put(Frame frame, std::uint64_t overtaken_so_far) {
  const std::lock_guard lock(mutex);
  const std::uint64_t left_out = overtaken_so_far - overtaken;
  overtaken = overtaken_so_far;
  read += left_out;
  stats.missed += left_out;
  frame.camera_frame_id = read++;
  last_sign = Clock::now();
  if (waiting.size() == options.waiting) {
    waiting.pop_front();
    ++stats.missed;
    ++stats.underruns;
  }
  waiting.push_back(std::move(frame));
  changed.notify_all();
}

/// Until the device is gone, and says why; or until it is told to stop.
void DeviceFeed::Shared::read_all(DeviceConnection& device) {
  bool there = true;
  const auto read_one = [&] {
    std::optional<Frame> frame = device.read();
    there = frame.has_value();
    if (there) put(*std::move(frame), device.overtaken());
  };
  const auto gone = [&](const std::exception_ptr& error) {
    there = false;
    const std::lock_guard lock(mutex);
    trouble = words_of(error);
  };
  while (there && !stopped_while(milliseconds(0))) guarded(read_one, gone);
}

/// Tries until the device is back; null when it is told to stop. `pause`: before the first attempt, and after it
/// before the next one.
std::unique_ptr<DeviceConnection> DeviceFeed::Shared::reopened(milliseconds& pause) {
  while (!stopped_while(pause)) {
    pause = std::min(2 * pause, std::max(kFirstPause, options.longest_pause));
    try {
      auto device = open();
      const std::lock_guard lock(mutex);
      ++stats.reopened;
      trouble.clear();
      overtaken = 0;
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
  milliseconds pause = kFirstPause;
  while (device) {
    const Clock::time_point opened = Clock::now();
    read_all(*device);
    device.reset();
    if (stopped_while(milliseconds(0))) break;
    const Clock::time_point gone = Clock::now();
    if (gone - opened > kSteady) pause = kFirstPause;
    tell_gone();
    device = reopened(pause);
    if (device) tell_back(Clock::now() - gone);
  }
  end({});
}

void DeviceFeed::Shared::tell_gone() const {
  const std::lock_guard lock(mutex);
  log_warning("camera", (trouble.empty() ? options.name + " has stopped delivering" : trouble) +
                            "; it is opened again as soon as it answers");
}

void DeviceFeed::Shared::tell_back(Clock::duration after) const {
  log_info("camera",
           options.name + format(" delivers again, after %.1f s", std::chrono::duration<double>(after).count()));
}

void DeviceFeed::Shared::end(const std::string& why) {
  const std::lock_guard lock(mutex);
  trouble = why;
  closed = true;
  changed.notify_all();
}

DeviceFeed::DeviceFeed(OpenDevice open, FeedOptions options)
    : shared_(std::make_shared<Shared>(std::move(open), std::move(options))) {
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
  stats.incomplete += !frame.complete;
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
