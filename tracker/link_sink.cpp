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
    link_.kept_by_.push_back(camera_);
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

std::vector<std::uint64_t> LinkSink::unacknowledged() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> waiting(entrances_.size(), 0);
  for (std::size_t i = sender_.stats().acknowledged; i < kept_by_.size(); ++i) ++waiting[kept_by_[i]];
  return waiting;
}

}  // namespace sheen
