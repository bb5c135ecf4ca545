// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/packet_queue.h"

extern "C" {
#include <libavcodec/packet.h>
}

#include <new>
#include <utility>

namespace sheen {
namespace {

constexpr std::size_t kMost = 60;  ///< that wait: two seconds of a decoder that is too slow

}  // namespace

void FreePacket::operator()(AVPacket* packet) const {
  av_packet_free(&packet);
}

PacketPtr make_packet() {
  PacketPtr packet(av_packet_alloc());
  if (!packet) throw std::bad_alloc();
  return packet;
}

void PacketQueue::put(PacketPtr packet, std::int64_t at_ns) {
  const std::lock_guard lock(mutex_);
  const bool alone = packet->flags & AV_PKT_FLAG_KEY;
  if (alone) broken_ = false;
  if (alone || packets_.size() >= kMost) {
    broken_ = !alone;
    overtaken_ += packets_.size();
    packets_.clear();
  }
  if (broken_) {
    ++overtaken_;
    return;
  }
  packets_.push_back({std::move(packet), at_ns});
  changed_.notify_all();
}

void PacketQueue::end(const std::string& why) {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  why_ = why;
  changed_.notify_all();
}

PacketQueue::Arrived PacketQueue::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ended_ || !packets_.empty(); });
  if (packets_.empty()) return {};
  Arrived next = std::move(packets_.front());
  packets_.pop_front();
  return next;
}

std::size_t PacketQueue::waiting() const {
  const std::lock_guard lock(mutex_);
  return packets_.size();
}

std::uint64_t PacketQueue::overtaken() const {
  const std::lock_guard lock(mutex_);
  return overtaken_;
}

std::string PacketQueue::why_ended() const {
  const std::lock_guard lock(mutex_);
  return why_;
}

}  // namespace sheen
