// SPDX-License-Identifier: Apache-2.0
#include "tracker/rig_tracking.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <thread>
#include <utility>

#include "common/base/guarded_thread.h"

namespace sheen {
namespace {

constexpr std::int64_t kPublishEvery_ns = 190'000'000;  ///< a little less than a camera does

/// The worst first: a camera that fell silent is news, one that has not begun yet less so.
constexpr std::array kByConcern{SourceState::kStale, SourceState::kStarting, SourceState::kLive, SourceState::kEnded};

SourceState worst(const std::vector<std::pair<std::string, Status>>& cameras) {
  for (const SourceState state : kByConcern)
    if (std::any_of(cameras.begin(), cameras.end(), [&](const auto& c) { return c.second.state == state; }))
      return state;
  return SourceState::kUnspecified;
}

}  // namespace

Status joined(const std::vector<std::pair<std::string, Status>>& cameras) {
  if (cameras.size() == 1 && cameras.front().first.empty()) return cameras.front().second;
  Status all = cameras.front().second;
  all.state = worst(cameras);
  all.message.clear();
  all.gauges.clear();
  for (const auto& [name, status] : cameras) {
    all.clock_ns = std::max(all.clock_ns, status.clock_ns);
    const std::string line = (all.message.empty() ? "" : "; ") + name + ": " + status.message;
    if (all.message.size() + line.size() <= kMaxTextBytes) all.message += line;
    for (const auto& [gauge, value] : status.gauges) {
      all.gauges[name + "/" + gauge] = value;
      if (!gauge.ends_with("_s")) all.gauges[gauge] += value;
    }
  }
  return all;
}

struct RigTracking::Impl {
  std::vector<TrackedCamera> cameras;
  std::vector<std::unique_ptr<TrackingLoop>> loops;

  std::mutex mutex;  // guards everything below
  RigReport report;
  std::vector<std::pair<std::string, Status>> statuses;
  std::int64_t published_ns = 0;

  void track(std::size_t i, const Hooks& hooks);
  void fail(std::size_t i, const std::exception_ptr& error);
  void take_status(std::size_t i, const Status& status, const Hooks& hooks);
};

RigTracking::RigTracking(std::vector<TrackedCamera> cameras) : impl_(std::make_unique<Impl>()) {
  impl_->cameras = std::move(cameras);
  for (TrackedCamera& camera : impl_->cameras) {
    impl_->loops.push_back(std::make_unique<TrackingLoop>(*camera.source, *camera.sink, camera.rig, camera.options));
    impl_->report.push_back({.name = camera.name, .report = {}});
    impl_->statuses.emplace_back(camera.name, Status{});
  }
}

RigTracking::~RigTracking() = default;

void RigTracking::Impl::take_status(std::size_t i, const Status& status, const Hooks& hooks) {
  const std::lock_guard lock(mutex);
  const bool news = statuses[i].second.state != status.state;
  statuses[i].second = status;
  if (!news && status.clock_ns - published_ns < kPublishEvery_ns) return;
  const bool all_speak = std::all_of(statuses.begin(), statuses.end(), [](const auto& s) { return s.second.clock_ns; });
  if (!all_speak) return;
  published_ns = status.clock_ns;
  hooks.publish(joined(statuses));
}

void RigTracking::Impl::track(std::size_t i, const Hooks& hooks) {
  TrackingLoop::Hooks own{.stop = hooks.stop};
  if (hooks.publish) own.publish = [&, i](const Status& status) { take_status(i, status, hooks); };
  own.progress = [&, i](const TrackingReport& so_far) {
    const std::lock_guard lock(mutex);
    report[i].report = so_far;
    if (hooks.progress) hooks.progress(report);
  };
  TrackingReport whole = loops[i]->run(own);
  const std::lock_guard lock(mutex);
  if (const std::string failure = whole.failure_text(); !failure.empty()) {
    whole.trouble = failure;
    if (hooks.failed) hooks.failed((cameras[i].name.empty() ? "" : cameras[i].name + ": ") + failure);
  }
  report[i].report = std::move(whole);
  if (hooks.progress) hooks.progress(report);
}

void RigTracking::Impl::fail(std::size_t i, const std::exception_ptr& error) {
  const std::lock_guard lock(mutex);
  report[i].report.failure = error;
}

RigReport RigTracking::run(const Hooks& hooks) {
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; i < impl_->loops.size(); ++i)
      threads.push_back(guarded_thread([this, i, &hooks] { impl_->track(i, hooks); },
                                       [this, i](const std::exception_ptr& error) { impl_->fail(i, error); }));
    guarded([&] { impl_->track(0, hooks); }, [this](const std::exception_ptr& error) { impl_->fail(0, error); });
  }
  const std::lock_guard lock(impl_->mutex);
  if (hooks.publish) hooks.publish(joined(impl_->statuses));
  return impl_->report;
}

}  // namespace sheen
