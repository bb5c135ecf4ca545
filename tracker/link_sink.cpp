// SPDX-License-Identifier: Apache-2.0
#include "tracker/link_sink.h"

#include <utility>

#include "common/base/clock.h"

namespace sheen {

class LinkSink::Entrance : public CaptureSink {
 public:
  Entrance(LinkSink& link, std::uint32_t camera) : link_(link), camera_(camera) {}

  bool keep(Capture capture, std::chrono::milliseconds timeout) override {
    capture.times.sent_ns = steady_now_ns();
    const std::lock_guard lock(link_.mutex_);  // the sender numbers them in this order
    if (!link_.sender_.keep(std::move(capture), timeout)) return false;
    link_.waiting_.push_back(camera_);
    link_.forget_acknowledged();
    return true;
  }
  void live(Capture capture) override {
    capture.times.sent_ns = steady_now_ns();
    link_.sender_.live(std::move(capture));
  }

 private:
  LinkSink& link_;
  const std::uint32_t camera_;
};

LinkSink::LinkSink(CaptureSender& sender, std::size_t cameras) : sender_(sender) {
  for (std::uint32_t i = 0; i < cameras; ++i) entrances_.push_back(std::make_unique<Entrance>(*this, i));
}

LinkSink::~LinkSink() = default;

CaptureSink& LinkSink::of(std::size_t camera) {
  return *entrances_.at(camera);
}

void LinkSink::forget_acknowledged() {
  const std::uint64_t acknowledged = sender_.stats().acknowledged;
  for (; forgotten_ < acknowledged && !waiting_.empty(); ++forgotten_) waiting_.pop_front();
}

std::vector<std::uint64_t> LinkSink::unacknowledged() {
  const std::lock_guard lock(mutex_);
  forget_acknowledged();
  std::vector<std::uint64_t> waiting(entrances_.size(), 0);
  for (const std::uint32_t camera : waiting_) ++waiting[camera];
  return waiting;
}

}  // namespace sheen
