// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_model.h"

#include <time.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "reconstructor/page/live_page.h"

namespace sheen {
namespace {

/// That this thread has had. On a busy machine an answer takes longer and costs no more.
std::chrono::nanoseconds processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

std::chrono::nanoseconds ProcessorAllowance::left() {
  constexpr double kShare = 0.02;  // of all processors; what HTTP takes comes on top
  static const double per_second = kShare * std::max(1u, std::thread::hardware_concurrency());
  const auto now = Clock::now();
  const auto earned = std::chrono::duration_cast<std::chrono::nanoseconds>(per_second * (now - known_at_));
  known_at_ = now;
  return left_ = std::min<std::chrono::nanoseconds>(kMostSaved, left_ + earned);
}

void ProcessorAllowance::spend(const std::function<void()>& work) {
  const std::chrono::nanoseconds begun = processor_time();
  work();
  left_ -= processor_time() - begun;
}

void LiveModel::watch(const ModelKind& kind, LoopObserver& observer) {
  stream_ = kind.make_stream();  // nobody asks it before there is a snapshot
  if (!stream_) return;
  observer.on_snapshot = [this, show = observer.on_snapshot](std::shared_ptr<const ModelSnapshot> snapshot,
                                                             std::shared_ptr<const RayPainter> painter) {
    {
      const std::lock_guard lock(mutex_);
      snapshot_ = snapshot;
      if (std::exchange(followed_, false)) since_ = std::chrono::steady_clock::now();
    }
    if (show) show(std::move(snapshot), std::move(painter));
  };
}

bool LiveModel::there() const {
  const std::lock_guard lock(mutex_);
  return snapshot_ != nullptr;
}

std::string_view LiveModel::page() const {
  return live_page();
}

ServedModel::Answer LiveModel::scene() {
  return answer([](ModelStream& stream) { return stream.scene(); });
}

ServedModel::Answer LiveModel::changes_for(const DeskQuestion& question) {
  const DeskState desk{.scene = question.scene,
                       .changes = question.changes,
                       .eye = {question.eye[0], question.eye[1], question.eye[2]},
                       .moved = question.moved && allowance_.left() > std::chrono::nanoseconds(0)};
  return answer([&desk](ModelStream& stream) { return stream.changes_for(desk); });
}

ServedModel::Answer LiveModel::answer(const std::function<std::string(ModelStream&)>& bytes) {
  constexpr std::chrono::milliseconds kMostOwed{200};  // two snapshots for four desks, about
  std::unique_lock lock(mutex_);
  if (!snapshot_) return {404, "There is no model yet.\n"};
  if (allowance_.left() < -kMostOwed) return {503, "Ask again in a moment.\n"};
  const std::shared_ptr<const ModelSnapshot> snapshot = snapshot_;
  const auto since = since_;
  followed_ = true;
  lock.unlock();
  Answer answer{200, {}};
  allowance_.spend([&] {
    stream_->follow(snapshot, since);
    answer.bytes = bytes(*stream_);
  });
  return answer;
}

}  // namespace sheen
