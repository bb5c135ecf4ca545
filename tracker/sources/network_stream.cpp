// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/network_stream.h"

#include <thread>
#include <type_traits>
#include <utility>

#include "common/base/clock.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/guarded_thread.h"
#include "tracker/sources/packet_queue.h"
#include "tracker/sources/picture_decoder.h"
#include "tracker/sources/stream_address.h"
#include "tracker/sources/stream_reader.h"

namespace sheen {
namespace {

constexpr int kMostDamaged = 60;  ///< pictures before the first that is whole

}  // namespace

struct NetworkStream::Impl {
  const std::string shown;  ///< the address, without its password
  StreamReader reader;
  PictureDecoder pictures;
  PacketQueue packets;
  std::uint64_t skipped = 0;  ///< decoded, as others need them, but not delivered
  std::int64_t arrived_ns = 0;
  std::optional<Frame> first;  ///< delivered by the first `read`
  StreamSize size;
  std::jthread pump;  // last: it uses the others

  Impl(const std::string& address, std::shared_ptr<const std::atomic<bool>> given_up)
      : shown(without_password(address)),
        reader(address, std::move(given_up)),
        pictures(named([this] { return PictureDecoder(reader.stream(), PictureDecoder::Kind::kLive); })) {}
  ~Impl() { reader.give_up(); }
  [[noreturn]] void fail(const std::string& what) const { throw DeviceError(shown + " " + what); }
  /// What the decoder throws, with its subject.
  template <typename Step>
  std::invoke_result_t<const Step&> named(const Step& step) const {
    try {
      return step();
    } catch (const Error& error) {
      fail(error.what());
    }
  }
  Frame next();
  Frame first_whole();
  bool is_overtaken() const;
  void check_size(const StreamSize& expected) const;
};

/// A picture for which newer ones wait already; the last but one is delivered, so that something always is.
bool NetworkStream::Impl::is_overtaken() const {
  return packets.waiting() > 1;
}

Frame NetworkStream::Impl::next() {
  for (;;) {
    const PictureDecoder::Step step = pictures.step();
    if (step == PictureDecoder::Step::kPicture && is_overtaken()) {
      ++skipped;
      continue;
    }
    Frame frame;
    frame.times = {.device_ns = arrived_ns, .grabbed_ns = arrived_ns};
    frame.complete = step != PictureDecoder::Step::kDamaged;
    if (step == PictureDecoder::Step::kPicture) frame.image = named([this] { return pictures.picture(); }).image;
    if (step == PictureDecoder::Step::kPicture || step == PictureDecoder::Step::kDamaged) return frame;
    const PacketQueue::Arrived arrived = packets.take();
    if (!arrived.packet) fail(packets.why_ended());
    arrived_ns = arrived.at_ns;
    if (pictures.feed(arrived.packet.get())) continue;
    frame.times = {.device_ns = arrived_ns, .grabbed_ns = arrived_ns};
    frame.complete = false;
    return frame;
  }
}

Frame NetworkStream::Impl::first_whole() {
  for (int i = 0; i < kMostDamaged; ++i)
    if (Frame frame = next(); frame.complete) return frame;
  fail("delivers no picture that can be decoded: set the app to MJPEG or H.264");
}

void NetworkStream::Impl::check_size(const StreamSize& expected) const {
  if (expected.width == 0 || (size.width == expected.width && size.height == expected.height)) return;
  throw ConfigError(shown + " delivers " + format("%d x %d", size.width, size.height) + " pixels, but " +
                    format("%d x %d", expected.width, expected.height) +
                    " are expected: hold the phone as it was held for the calibration, and set the app to that size");
}

NetworkStream::NetworkStream(const std::string& address, StreamSize expected,
                             std::shared_ptr<const std::atomic<bool>> given_up)
    : impl_(std::make_unique<Impl>(address, std::move(given_up))) {
  Impl& self = *impl_;
  self.pump = guarded_thread(
      [&self] {
        while (PacketPtr packet = self.reader.read()) self.packets.put(std::move(packet), steady_now_ns());
        self.packets.end(self.reader.why_ended());
      },
      [&self](const std::exception_ptr& error) { self.packets.end("cannot be read: " + words_of(error)); });
  Frame frame = self.first_whole();
  self.size = {frame.image.width, frame.image.height};
  self.check_size(expected);
  self.first = std::move(frame);
}

NetworkStream::~NetworkStream() = default;

StreamSize NetworkStream::size() const {
  return impl_->size;
}

std::string NetworkStream::warning() const {
  return impl_->pictures.warning(impl_->shown);
}

std::optional<Frame> NetworkStream::read() {
  Impl& self = *impl_;
  if (self.first) return std::exchange(self.first, std::nullopt);
  Frame frame = self.next();
  if (frame.complete && (frame.image.width != self.size.width || frame.image.height != self.size.height))
    self.fail(format("delivers %d x %d pixels by now, and began with %d x %d: was the phone turned? Hold it as it was",
                     frame.image.width, frame.image.height, self.size.width, self.size.height));
  return frame;
}

std::uint64_t NetworkStream::overtaken() const {
  return impl_->packets.overtaken() + impl_->skipped;
}

}  // namespace sheen
