// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_model.h"

#include <time.h>

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

void LiveModel::watch(const ModelKind& kind, LoopObserver& observer) {
  stream_ = kind.make_stream();  // nobody asks it before there is a snapshot
  if (!stream_) return;
  observer.on_snapshot = [this, show = observer.on_snapshot](std::shared_ptr<const ModelSnapshot> snapshot,
                                                             std::shared_ptr<const RayPainter> painter) {
    {
      const std::lock_guard lock(mutex_);
      snapshot_ = snapshot;
    }
    if (show) show(std::move(snapshot), std::move(painter));
  };
}

std::shared_ptr<const ModelSnapshot> LiveModel::latest() const {
  const std::lock_guard lock(mutex_);
  return snapshot_;
}

bool LiveModel::there() const {
  return latest() != nullptr;
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
                       .moved = question.moved};
  return answer([&desk](ModelStream& stream) { return stream.changes_for(desk); });
}

ServedModel::Answer LiveModel::answer(const std::function<std::string(ModelStream&)>& bytes) {
  constexpr int kRestPerWork = 20;  // so that all desks together cost a twentieth of a core at most
  std::shared_ptr<const ModelSnapshot> snapshot = latest();
  if (!snapshot) return {404, "There is no model yet.\n"};
  if (Clock::now() < rests_until_) return {503, "Ask again in a moment.\n"};
  const std::chrono::nanoseconds begun = processor_time();
  stream_->follow(std::move(snapshot));
  Answer answer{200, bytes(*stream_)};
  rests_until_ = Clock::now() + kRestPerWork * (processor_time() - begun);
  return answer;
}

}  // namespace sheen
