// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <zmq.hpp>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/link/link_sockets.h"
#include "common/link/retained_captures.h"
#include "common/link/transport.h"
#include "common/link/transport_internals.h"
#include "common/link/wire_messages.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kIdle{500};      // how soon a revoked key is noticed
constexpr milliseconds kRetry{10};      // after a full send buffer
constexpr milliseconds kLeaving{1000};  // within which the socket knows of a connection that broke
constexpr std::uint32_t kMaxCredits = 1024;
constexpr int kMostConnections =
    256;  // strangers and what is left of those that have gone; beyond it all are hung up on
const char* const kReceiverRole = "reconstructor";

using Message = RetainedCaptures::Message;

/// The one receiver that has said hello and been welcomed.
struct Peer {
  std::string routing_id;
  std::string public_key;  ///< empty without CURVE
  std::uint32_t credits = 0;
  std::uint64_t next = 1;  ///< sequence of the kept capture to send next
  bool end_sent = false;
  Clock::time_point heard = Clock::now();
};

}  // namespace

struct CaptureSender::Impl {
  using Sent = RouterSocket::Sent;

  explicit Impl(const SenderOptions& sender_options);
  void run(const std::stop_token& stop);
  void round();
  void hang_up(const std::string& why);
  void look_at_events(const std::vector<SocketEvents::Kind>& happened);
  void receive_all();
  void handle(const std::string& id, const std::string& key, MessageType type, std::span<const std::uint8_t> body);
  void welcome(const std::string& id, const std::string& key, const Hello& hello);
  void release_up_to(std::uint64_t durable);
  bool send_what_may_go();
  bool send_kept(RetainedCaptures::Kept& kept);
  bool send_live();
  bool send_end();
  void check_peer_is_there();
  void check_peer_is_allowed();
  void refuse(const std::string& id, const std::string& reason, const std::string& key = {});
  Sent send(const std::string& id, std::vector<zmq::message_t> parts);
  Sent send(const std::string& id, MessageType type, const Bytes& body) { return send(id, parts_of(type, body)); }
  Welcome make_welcome(std::int64_t hello_clock_ns) const;
  void stamp(Capture& capture) const;

  const SenderOptions options;
  zmq::context_t context{1};
  std::unique_ptr<ZapHandler> zap;
  std::optional<RouterSocket> router;
  bool later = false;  ///< something is left to send
  Clock::time_point look_until = Clock::now();
  Wakeup wake;
  std::string endpoint;

  std::mutex keep_order;     // one `keep` at a time, so that captures are queued in the order of their numbers
  mutable std::mutex mutex;  // guards everything below
  std::condition_variable changed;
  RetainedCaptures retained;
  Message newest_live;
  bool finishing = false, end_seen = false;
  std::string failure;  ///< said with the end
  TrackerFrames frames;
  std::uint64_t refused_by_zap = 0, refused_without_zap = 0;
  std::optional<Peer> peer;
  SparingLog refusals{"link"};
  SenderStats stats;

  std::jthread io;  // last: stops before what it uses is gone
};

CaptureSender::Impl::Impl(const SenderOptions& sender_options)
    : options(sender_options), retained(options.source_session, options.sent_before) {
  require_keys_beyond_loopback(options.endpoint, options.keys.has_value());
  if (options.source_session.empty()) throw ConfigError("source_session: must name this run of the source");
  if (options.retained == 0) throw ConfigError("retained: must be at least 1");
  if (options.keys) {
    if (options.allowlist.empty()) throw ConfigError("allowlist: with keys, name the file of those that may connect");
    zap = std::make_unique<ZapHandler>(context, options.allowlist, std::set<std::string>{kReceiverRole});
  }
  router.emplace(context, options.endpoint, options.keys ? &*options.keys : nullptr);
  endpoint = router->endpoint();
  io = guarded_thread([this](const std::stop_token& stop) { run(stop); },
                      [this](const std::exception_ptr& error) { refusals.tell("thread", words_of(error)); });
}

void CaptureSender::Impl::run(const std::stop_token& stop) {
  block_signals();
  const std::stop_callback on_stop(stop, [this] { wake.notify(); });
  while (!stop.stop_requested()) {
    const bool well = guarded([this] { round(); },
                              [this](const std::exception_ptr& error) {
                                const std::lock_guard lock(mutex);
                                refusals.tell("thread", "goes on after: " + words_of(error));
                              });
    if (!well) std::this_thread::sleep_for(kFaultPause);
  }
}

void CaptureSender::Impl::round() {
  if (!router->is_open()) router->open_again();
  std::array<zmq::pollitem_t, 4> items{{{router->socket(), 0, ZMQ_POLLIN, 0},
                                        {router->events(), 0, ZMQ_POLLIN, 0},
                                        {nullptr, wake.fd(), ZMQ_POLLIN, 0},
                                        {zap ? zap->socket() : nullptr, 0, ZMQ_POLLIN, 0}}};
  zmq::poll(items.data(), zap ? 4 : 3, later ? kRetry : kIdle);
  wake.drain();
  const std::lock_guard lock(mutex);
  if (zap) {
    zap->answer(refusals);
    check_peer_is_allowed();
  }
  // Events are taken before messages and looked at after them: what a peer said before it left still counts.
  const std::vector<SocketEvents::Kind> happened = router->drain();
  receive_all();
  look_at_events(happened);
  if (!router->is_open()) return;
  if (peer && Clock::now() - peer->heard > kSilence) peer.reset();  // frozen: another may take its place
  // The event comes a moment before the socket refuses to send: once is not enough.
  const bool may_have_left = peer && Clock::now() < look_until;
  if (may_have_left) check_peer_is_there();
  later = !send_what_may_go() || may_have_left;
  changed.notify_all();
}

void CaptureSender::Impl::look_at_events(const std::vector<SocketEvents::Kind>& happened) {
  for (const SocketEvents::Kind kind : happened) {
    if (kind == SocketEvents::Kind::kDisconnected) look_until = Clock::now() + kLeaving;
    if (kind == SocketEvents::Kind::kHandshakeFailed) {
      ++refused_without_zap;
      stats.last_refusal = "a handshake failed: the other side has no keys, or those of another sender";
      refusals.tell(stats.last_refusal, stats.last_refusal);
    }
    if (kind == SocketEvents::Kind::kHandshakeBroken) ++stats.broken_handshakes;
  }
  if (router->is_open() && router->connections() > kMostConnections)
    hang_up("connections: more than " + std::to_string(kMostConnections));
}

/// On all: honest receivers call again at once, and go on where they were.
void CaptureSender::Impl::hang_up(const std::string& why) {
  stats.last_refusal = why + "; all were hung up on";
  ++stats.hung_up;
  refusals.tell("flood", stats.last_refusal);
  peer.reset();
  router->close();
}

void CaptureSender::Impl::receive_all() {
  std::vector<zmq::message_t> parts;  // routing id, envelope, body
  for (int received = 0; router->receive(parts); ++received) {
    if (received == kFlood) return hang_up("flood: " + std::to_string(kFlood) + " messages without a pause");
    const std::string id = parts[0].to_string();
    try {
      if (parts.size() != 3) throw ProtocolError("message: has the wrong number of parts");
      const Envelope envelope = decode_envelope({parts[1].data<std::uint8_t>(), parts[1].size()});
      if (const std::string error = version_error(envelope, "the receiver"); !error.empty()) throw ProtocolError(error);
      handle(id, public_key_of(parts[1]), envelope.type, {parts[2].data<std::uint8_t>(), parts[2].size()});
    } catch (const ProtocolError& error) {
      ++stats.rejected_messages;
      refuse(id, error.what());
    }
  }
}

void CaptureSender::Impl::handle(const std::string& id, const std::string& key, MessageType type,
                                 std::span<const std::uint8_t> body) {
  if (type == MessageType::kHello) return welcome(id, key, decode_hello(body));
  if (type == MessageType::kRefuse) {
    ++stats.rejected_messages;
    stats.last_refusal = "the receiver refused: " + decode_refuse(body).reason;
    return;
  }
  if (type != MessageType::kCredit && type != MessageType::kAck)
    throw ProtocolError("envelope.type: " + std::to_string(static_cast<int>(type)) + " is not for a sender");
  if (!peer || peer->routing_id != id) return refuse(id, "say hello first");
  peer->heard = Clock::now();
  if (type == MessageType::kCredit) {
    const Credit credit = decode_credit(body);
    peer->credits = std::min(kMaxCredits, peer->credits + credit.captures);
    if (credit.clock_ns != 0) send(id, MessageType::kWelcome, encode(make_welcome(credit.clock_ns)));
    return;
  }
  const Ack ack = decode_ack(body);
  if (ack.source_session != options.source_session) return;  // of an earlier run; nothing here waits for it
  retained.require_sent(ack.durable, "ack.durable");
  release_up_to(ack.durable);
  end_seen |= ack.end_seen && finishing;
}

void CaptureSender::Impl::welcome(const std::string& id, const std::string& key, const Hello& hello) {
  if (zap)
    if (const std::string why = zap->refusal(key); !why.empty()) return refuse(id, why, key);
  if (peer && peer->routing_id != id) {
    check_peer_is_there();
    if (peer) return refuse(id, "busy: another receiver uses this data link; stop it, or wait until it has ended");
  }
  const auto held = hello.held.find(options.source_session);
  if (held != hello.held.end()) {
    retained.require_sent(held->second.durable, "hello.held.durable");
    retained.require_sent(held->second.received, "hello.held.received");
    release_up_to(held->second.durable);
  }
  const std::uint64_t received = held == hello.held.end() ? 0 : std::max(held->second.received, held->second.durable);
  const Welcome answer = make_welcome(hello.clock_ns);
  if (send(id, MessageType::kWelcome, encode(answer)) != Sent::kYes) {
    peer.reset();
    return;
  }
  peer = Peer{.routing_id = id,
              .public_key = key,
              .credits = hello.credits,
              .next = std::max(received + 1, answer.first_sequence)};
}

Welcome CaptureSender::Impl::make_welcome(std::int64_t hello_clock_ns) const {
  return {.source_session = options.source_session,
          .first_sequence = retained.first_sequence(),
          .hello_clock_ns = hello_clock_ns,
          .clock_ns = steady_now_ns(),
          .frames = frames,
          .motion = options.motion};
}

void CaptureSender::Impl::release_up_to(std::uint64_t sequence) {
  stats.acknowledged += retained.release_up_to(sequence);
}

/// False when something is left that must be tried again soon.
bool CaptureSender::Impl::send_what_may_go() {
  while (peer && peer->credits > 0) {
    if (!retained.empty()) peer->next = std::max(peer->next, retained.first_sequence());
    if (RetainedCaptures::Kept* const kept = retained.find(peer->next)) {
      if (!send_kept(*kept)) return !peer;
    } else if (newest_live) {
      if (!send_live()) return !peer;
    } else {
      break;
    }
  }
  return send_end() || !peer;
}

bool CaptureSender::Impl::send_kept(RetainedCaptures::Kept& kept) {
  if (send(peer->routing_id, parts_of(kept.message)) != Sent::kYes) return false;
  ++(kept.sent_before ? stats.resent : stats.delivered);
  retained.note_sent(kept);
  ++peer->next;
  --peer->credits;
  return true;
}

bool CaptureSender::Impl::send_live() {
  if (send(peer->routing_id, parts_of(newest_live)) != Sent::kYes) return false;
  newest_live.reset();
  ++stats.live_sent;
  --peer->credits;
  return true;
}

bool CaptureSender::Impl::send_end() {
  if (!finishing || !peer || peer->end_sent || peer->next <= retained.last_sequence()) return true;
  if (frames.judged > 0) check_peer_is_there();  // the last counts, before the end
  if (!peer) return false;
  const End end{options.source_session, retained.last_sequence(), failure};
  if (send(peer->routing_id, MessageType::kEnd, encode(end)) != Sent::kYes) return false;
  peer->end_sent = true;
  return true;
}

/// A router only tells on sending that a connection is gone, so greet it again: a welcome changes nothing.
void CaptureSender::Impl::check_peer_is_there() {
  if (peer) send(peer->routing_id, MessageType::kWelcome, encode(make_welcome(0)));
}

void CaptureSender::Impl::check_peer_is_allowed() {
  if (refused_by_zap < zap->refused()) stats.last_refusal = zap->last_refusal();
  refused_by_zap = zap->refused();
  if (!peer) return;
  if (const std::string why = zap->refusal(peer->public_key); !why.empty()) {
    ++refused_without_zap;
    const Peer gone = *peer;
    peer.reset();
    refuse(gone.routing_id, why, gone.public_key);
  }
}

void CaptureSender::Impl::refuse(const std::string& id, const std::string& reason, const std::string& key) {
  stats.last_refusal = reason;
  refusals.tell(key.empty() ? reason_of(reason) : key, "refused: " + reason);
  send(id, MessageType::kRefuse, encode(Refuse{reason}));
}

CaptureSender::Impl::Sent CaptureSender::Impl::send(const std::string& id, std::vector<zmq::message_t> parts) {
  const Sent sent = router->send(id, std::move(parts));
  if (sent == Sent::kUnreachable && peer && peer->routing_id == id) peer.reset();
  return sent;
}

void CaptureSender::Impl::stamp(Capture& capture) const {
  if (capture.source_session.empty()) capture.source_session = options.source_session;
  if (capture.source_session != options.source_session)
    throw ProtocolError("source_session: is " + capture.source_session + ", the sender's is " + options.source_session);
  capture.times.sent_ns = steady_now_ns();
}

CaptureSender::CaptureSender(const SenderOptions& options) : impl_(std::make_unique<Impl>(options)) {}
CaptureSender::~CaptureSender() = default;

bool CaptureSender::keep(Capture capture, milliseconds timeout) {
  const std::lock_guard order(impl_->keep_order);
  std::uint64_t sequence = 0;
  {
    std::unique_lock lock(impl_->mutex);
    if (impl_->finishing) throw Error("the sender has finished; nothing more can be kept");
    const auto has_room = [&] { return impl_->retained.size() < impl_->options.retained; };
    if (!impl_->changed.wait_for(lock, timeout, has_room)) return false;
    sequence = impl_->retained.last_sequence() + 1;
    const bool first = impl_->retained.last_sequence() == 0;
    if (capture.sequence == 0) capture.sequence = sequence;
    if (capture.sequence != sequence && !first)
      throw ProtocolError("sequence: is " + std::to_string(capture.sequence) + ", must be " + std::to_string(sequence));
    sequence = capture.sequence;
  }
  impl_->stamp(capture);
  auto message =
      std::make_shared<const EncodedCapture>(encode_capture(capture, MessageType::kKeep, impl_->options.codec));
  {
    const std::lock_guard lock(impl_->mutex);
    ++impl_->stats.kept;
    impl_->retained.add(sequence, std::move(message));
    impl_->release_up_to(
        impl_->retained.durable());  // a source that starts again may repeat what is on the disk already
  }
  impl_->wake.notify();
  return true;
}

void CaptureSender::live(Capture capture) {
  impl_->stamp(capture);
  auto message =
      std::make_shared<const EncodedCapture>(encode_capture(capture, MessageType::kLive, impl_->options.codec));
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->newest_live) ++impl_->stats.live_dropped;
    impl_->newest_live = std::move(message);
  }
  impl_->wake.notify();
}

bool CaptureSender::finish(milliseconds timeout, const std::string& failure) {
  std::unique_lock lock(impl_->mutex);
  if (!impl_->finishing) impl_->failure = sayable(failure);
  impl_->finishing = true;
  impl_->wake.notify();
  return impl_->changed.wait_for(lock, timeout, [&] { return impl_->retained.empty() && impl_->end_seen; });
}

void CaptureSender::report(const TrackerFrames& frames) {
  const std::lock_guard lock(impl_->mutex);
  impl_->frames = frames;
  impl_->frames.trouble = sayable(frames.trouble);
}

std::string CaptureSender::endpoint() const {
  return impl_->endpoint;
}

SenderStats CaptureSender::stats() const {
  const std::lock_guard lock(impl_->mutex);
  SenderStats stats = impl_->stats;
  stats.refused_keys = impl_->refused_by_zap + impl_->refused_without_zap;
  stats.peer_connected = impl_->peer.has_value();
  return stats;
}

}  // namespace sheen
