// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <zmq.hpp>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/link/link_sockets.h"
#include "common/link/transport.h"
#include "common/link/transport_internals.h"
#include "common/link/wire_messages.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kPoll{100}, kPollUntilWelcome{10};
constexpr milliseconds kHelloAgain{500};    // while no welcome comes; then twice as late each time, for only the answer
constexpr milliseconds kHelloLatest{8000};  // to the latest hello counts, and it may come behind images on a slow link
constexpr milliseconds kResendPause{100};   // between two requests to send again
constexpr milliseconds kReopenPause{500};   // after a refused handshake
constexpr milliseconds kCompareClocks{1000};
constexpr milliseconds kLastWords{250};  // for acknowledgements to leave when the receiver closes
constexpr int kMaxCredits = 256;
const char* const kRole = "reconstructor";

std::span<const std::uint8_t> bytes_of(const zmq::message_t& part) {
  return {part.data<std::uint8_t>(), part.size()};
}

}  // namespace

struct CaptureReceiver::Impl {
  explicit Impl(const ReceiverOptions& receiver_options);
  ~Impl();
  void run(const std::stop_token& stop);
  void call_again();
  void round(milliseconds& wait);
  void note_fault(const std::string& what);
  void handle_events();
  void receive_all();
  void hang_up();
  void handle(const std::vector<zmq::message_t>& parts);
  void require_credit(std::uint64_t bytes);
  void take_kept(Capture capture);
  void take_welcome(const Welcome& welcome);
  void take_end(const End& end);
  void take_refusal(const Refuse& refuse);
  void ask_again(const std::string& why);
  void say_what_is_due();
  void say_credits();
  void say_hello();
  void reject(const std::string& error);
  void deliver(Capture capture, bool live);

  const ReceiverOptions options;
  zmq::context_t context{1};
  std::optional<DealerSocket> dealer;
  Wakeup wake;

  mutable std::mutex mutex;  // guards everything below
  std::condition_variable arrived;
  std::deque<Received> queue;
  std::map<std::string, HeldCaptures> held;
  std::set<std::string> unsaid_acks;
  std::map<std::string, std::string> refused;  ///< source sessions, and why
  std::string unsaid_refusal;
  std::uint32_t unsaid_credits = 0;
  std::uint32_t may_come = 0;          ///< captures that the sender has credits for, or had until the latest hello
  std::uint32_t granted_by_hello = 0;  ///< of these, by the latest hello
  std::string session;                 ///< the sender's, once it has welcomed us
  bool link_up = false, welcomed = false, end_unsaid = false;
  Clock::time_point hello_due{}, last_hello{};
  milliseconds hello_wait = kHelloAgain;  ///< for the answer to the next hello
  std::int64_t hello_clock_ns = 0;        ///< of the latest hello
  std::int64_t asked_clock_ns = 0;        ///< of the latest question about the sender's clock
  Clock::time_point ask_clock_due{};
  ClockComparison clock;
  std::optional<Clock::time_point> reopen_due;
  Clock::time_point heard{};  ///< the latest message
  ReceiverStats stats;

  std::jthread io;  // last: stops before what it uses is gone
};

CaptureReceiver::Impl::Impl(const ReceiverOptions& receiver_options) : options(receiver_options) {
  require_keys_beyond_loopback(options.endpoint, options.keys.has_value());
  if (options.credits < 1 || options.credits > kMaxCredits)
    throw ConfigError("credits: must be 1.." + std::to_string(kMaxCredits));
  for (const auto& [source, sequence] : options.held) held[source] = {sequence, sequence};
  dealer.emplace(context, options);
  io = guarded_thread([this](const std::stop_token& stop) { run(stop); },
                      [this](const std::exception_ptr& error) { note_fault(words_of(error)); });
}

CaptureReceiver::Impl::~Impl() {
  io.request_stop();
  io.join();
  dealer->close_with_last_words(kLastWords);
}

void CaptureReceiver::Impl::call_again() {
  dealer->open_again();
  reopen_due.reset();
  link_up = welcomed = false;
}

void CaptureReceiver::Impl::run(const std::stop_token& stop) {
  block_signals();
  const std::stop_callback on_stop(stop, [this] { wake.notify(); });
  milliseconds wait = kPollUntilWelcome;
  while (!stop.stop_requested()) {
    const bool well =
        guarded([&] { round(wait); }, [this](const std::exception_ptr& error) { note_fault(words_of(error)); });
    if (!well) std::this_thread::sleep_for(kFaultPause);
  }
  const std::lock_guard lock(mutex);
  say_what_is_due();  // the last acknowledgements
}

void CaptureReceiver::Impl::round(milliseconds& wait) {
  std::array<zmq::pollitem_t, 3> items{{{dealer->socket(), 0, ZMQ_POLLIN, 0},
                                        {dealer->events(), 0, ZMQ_POLLIN, 0},
                                        {nullptr, wake.fd(), ZMQ_POLLIN, 0}}};
  zmq::poll(items.data(), items.size(), wait);
  wake.drain();
  handle_events();
  receive_all();
  const std::lock_guard lock(mutex);
  say_what_is_due();
  if (reopen_due && Clock::now() >= *reopen_due) call_again();
  wait = welcomed || !link_up ? kPoll : kPollUntilWelcome;
}

void CaptureReceiver::Impl::note_fault(const std::string& what) {
  const std::lock_guard lock(mutex);
  stats.last_error = "the link to " + options.endpoint + ": " + what;
}

void CaptureReceiver::Impl::handle_events() {
  const std::lock_guard lock(mutex);
  for (const SocketEvents::Kind kind : dealer->drain()) {
    if (kind == SocketEvents::Kind::kAccepted) continue;  // this side calls
    link_up = kind == SocketEvents::Kind::kConnected;
    welcomed = stats.connected = false;
    hello_due = Clock::now();
    hello_wait = kHelloAgain;
    clock.forget();  // who comes back may be another machine
    stats.clock.reset();
    if (kind == SocketEvents::Kind::kKeyRefused)
      stats.last_error = "the sender at " + options.endpoint + " refused this key; add it to the sender's allowlist";
    const bool failed = kind == SocketEvents::Kind::kHandshakeFailed || kind == SocketEvents::Kind::kHandshakeBroken;
    if (failed)
      stats.last_error = "handshake with " + options.endpoint +
                         " failed: only one side has keys, or the sender's public key is another one";
    if (failed || kind == SocketEvents::Kind::kKeyRefused)
      reopen_due = Clock::now() + kReopenPause;  // the library itself gives up after a refusal
  }
}

void CaptureReceiver::Impl::receive_all() {
  std::vector<zmq::message_t> parts;
  for (int received = 0; dealer->receive(parts); ++received) {
    if (received == kFlood) return hang_up();
    try {
      handle(parts);
    } catch (const ProtocolError& error) {
      const std::lock_guard lock(mutex);
      reject(error.what());
    }
    // Not only at the end: to unpack all that waits may take longer than a sender waits for a word.
    const std::lock_guard lock(mutex);
    say_what_is_due();
  }
}

/// All that waits is dropped with the socket; the next hello asks for what was missed.
void CaptureReceiver::Impl::hang_up() {
  const std::lock_guard lock(mutex);
  reject("flood: " + options.endpoint + " sends more than it may; hung up");
  stats.connected = false;
  call_again();
}

void CaptureReceiver::Impl::handle(const std::vector<zmq::message_t>& parts) {
  const Envelope envelope = decode_envelope(bytes_of(parts[0]));
  {
    const std::lock_guard lock(mutex);
    heard = Clock::now();
  }
  const bool is_capture = envelope.type == MessageType::kKeep || envelope.type == MessageType::kLive;
  if (const std::string error = version_error(envelope, "the sender"); !error.empty()) throw ProtocolError(error);
  if (parts.size() != (is_capture ? 3u : 2u)) throw ProtocolError("message: has the wrong number of parts");
  if (!is_capture) {
    const std::lock_guard lock(mutex);
    if (envelope.type == MessageType::kWelcome) return take_welcome(decode_welcome(bytes_of(parts[1])));
    if (envelope.type == MessageType::kEnd) return take_end(decode_end(bytes_of(parts[1])));
    if (envelope.type == MessageType::kRefuse) return take_refusal(decode_refuse(bytes_of(parts[1])));
    throw ProtocolError("envelope.type: " + std::to_string(static_cast<int>(envelope.type)) + " is not for a receiver");
  }
  {
    const std::lock_guard lock(mutex);
    require_credit(parts[1].size() + parts[2].size());
  }
  try {
    Capture capture = decode_capture(bytes_of(parts[0]), bytes_of(parts[1]), bytes_of(parts[2]));
    capture.times.received_ns = steady_now_ns();
    const std::lock_guard lock(mutex);
    stats.bytes += parts[1].size() + parts[2].size();
    if (envelope.type == MessageType::kKeep)
      take_kept(std::move(capture));
    else
      deliver(std::move(capture), true);
  } catch (const std::exception& error) {  // also where there is no memory for it now
    const std::lock_guard lock(mutex);
    ++unsaid_credits;
    if (envelope.type == MessageType::kKeep) ask_again(error.what());
    throw;
  }
}

/// Before anything is unpacked: what nobody asked for is dropped. A keyframe among it is missed, and asked for again,
/// by the next.
void CaptureReceiver::Impl::require_credit(std::uint64_t bytes) {
  if (may_come == 0)
    throw ProtocolError("credits: a capture of " + std::to_string(bytes) + " bytes came without a credit; dropped");
  --may_come;
}

/// Delivers a kept capture in its turn, once.
void CaptureReceiver::Impl::take_kept(Capture capture) {
  if (capture.source_session != session)
    throw ProtocolError("source_session: is " + capture.source_session + ", the sender's is " + session);
  HeldCaptures& have = held[session];
  if (const auto why = refused.find(session); why != refused.end()) {
    ++unsaid_credits;
    reject(why->second);
  } else if (capture.sequence <= have.received) {
    ++stats.duplicates;
    ++unsaid_credits;
  } else if (capture.sequence == have.received + 1) {
    have.received = capture.sequence;
    deliver(std::move(capture), false);
  } else {
    throw ProtocolError("gap: capture " + std::to_string(capture.sequence) + " of " + capture.source_session +
                        " came where " + std::to_string(have.received + 1) + " is next; asked to send again");
  }
}

void CaptureReceiver::Impl::deliver(Capture capture, bool live) {
  ++(live ? stats.live : stats.kept);
  queue.push_back({std::move(capture), live});
  arrived.notify_one();
  if (options.on_arrival) options.on_arrival();
}

void CaptureReceiver::Impl::take_welcome(const Welcome& welcome) {
  if (welcome.frames.judged > 0 || welcome.source_session != session) stats.tracker = welcome.frames;
  stats.motion = welcome.motion;
  if (welcome.hello_clock_ns != asked_clock_ns || asked_clock_ns == 0) return;  // not the answer to the latest question
  clock.add(asked_clock_ns, welcome.clock_ns, steady_now_ns());
  stats.clock = clock.best();
  asked_clock_ns = 0;
  if (welcomed || welcome.hello_clock_ns != hello_clock_ns) return;
  may_come = granted_by_hello;  // what was on its way before the hello has come
  HeldCaptures& have = held[welcome.source_session];
  if (welcome.first_sequence > have.received + 1) {
    const std::uint64_t lost = welcome.first_sequence - have.received - 1;
    stats.missing += lost;
    stats.last_error = "the sender no longer has captures " + std::to_string(have.received + 1) + " to " +
                       std::to_string(welcome.first_sequence - 1) + " of " + welcome.source_session +
                       ": another receiver acknowledged them";
    have.received = welcome.first_sequence - 1;
  } else {
    stats.last_error.clear();
  }
  if (session != welcome.source_session) stats.ended = false;
  session = welcome.source_session;
  welcomed = stats.connected = stats.came = true;
  hello_wait = kHelloAgain;
}

void CaptureReceiver::Impl::take_end(const End& end) {
  if (end.source_session != session)
    throw ProtocolError("end.source_session: is " + end.source_session + ", the sender's is " + session);
  if (!refused.contains(session) && end.last_sequence > held[session].received)
    return ask_again("gap: the last captures are missing");
  stats.ended = true;
  stats.source_failure = end.failure;
  end_unsaid = true;
  arrived.notify_all();
}

void CaptureReceiver::Impl::take_refusal(const Refuse& refuse) {
  stats.last_error = "the sender refused: " + refuse.reason;
  welcomed = stats.connected = false;
  hello_due = Clock::now() + kHelloAgain;
  hello_wait = kHelloAgain;
}

/// A new hello makes the sender go on after what this side has.
void CaptureReceiver::Impl::ask_again(const std::string& why) {
  stats.last_error = why;
  if (!welcomed) return;  // asked already
  welcomed = false;
  hello_due = std::max(Clock::now(), last_hello + kResendPause);
}

void CaptureReceiver::Impl::say_what_is_due() {
  if (!link_up) return;
  if (!welcomed) {
    if (Clock::now() >= hello_due) say_hello();
    return;
  }
  say_credits();
  if (!unsaid_refusal.empty() && dealer->send(MessageType::kRefuse, encode(Refuse{unsaid_refusal})))
    unsaid_refusal.clear();
  while (!unsaid_acks.empty() || end_unsaid) {
    const std::string source = unsaid_acks.empty() ? session : *unsaid_acks.begin();
    if (!dealer->send(MessageType::kAck, encode(Ack{source, held[source].durable, stats.ended && source == session})))
      return;
    unsaid_acks.erase(source);
    end_unsaid = end_unsaid && source != session;
  }
}

/// With the question what the sender's clock says, now and then.
void CaptureReceiver::Impl::say_credits() {
  const bool ask = Clock::now() >= ask_clock_due;
  if (unsaid_credits == 0 && !ask) return;
  const std::int64_t now_ns = steady_now_ns();
  if (!dealer->send(MessageType::kCredit, encode(Credit{unsaid_credits, ask ? now_ns : 0}))) return;
  may_come += unsaid_credits;
  unsaid_credits = 0;
  if (!ask) return;
  asked_clock_ns = now_ns;
  ask_clock_due = Clock::now() + kCompareClocks;
}

void CaptureReceiver::Impl::say_hello() {
  const auto waiting = std::min<std::size_t>(queue.size(), options.credits);
  const Hello hello{.role = kRole,
                    .credits = static_cast<std::uint32_t>(options.credits - waiting),
                    .held = held,
                    .clock_ns = steady_now_ns()};
  last_hello = Clock::now();
  if (!dealer->send(MessageType::kHello, encode(hello))) return;
  hello_due = last_hello + hello_wait;
  hello_wait = std::min(2 * hello_wait, kHelloLatest);
  hello_clock_ns = asked_clock_ns = hello.clock_ns;
  ask_clock_due = last_hello + kCompareClocks;
  granted_by_hello = hello.credits;
  // What is on its way may still come; with what waits here it is never more than twice the credits.
  const std::size_t most = 2 * static_cast<std::size_t>(options.credits);
  may_come = static_cast<std::uint32_t>(
      std::min<std::size_t>(may_come + granted_by_hello, most - std::min(most, queue.size())));
  unsaid_credits = 0;  // told by what hello grants
  unsaid_acks.clear();
}

void CaptureReceiver::Impl::reject(const std::string& error) {
  ++stats.rejected_messages;
  ++stats.rejected_by_reason[reason_of(error)];
  stats.last_error = error;
}

CaptureReceiver::CaptureReceiver(const ReceiverOptions& options) : impl_(std::make_unique<Impl>(options)) {}
CaptureReceiver::~CaptureReceiver() = default;

std::optional<Received> CaptureReceiver::next(milliseconds timeout) {
  std::optional<Received> received;
  {
    std::unique_lock lock(impl_->mutex);
    if (!impl_->arrived.wait_for(lock, timeout, [&] { return !impl_->queue.empty(); })) return std::nullopt;
    received = std::move(impl_->queue.front());
    impl_->queue.pop_front();
    ++impl_->unsaid_credits;
  }
  impl_->wake.notify();
  return received;
}

void CaptureReceiver::acknowledge(const std::string& source_session, std::uint64_t sequence) {
  {
    const std::lock_guard lock(impl_->mutex);
    HeldCaptures& have = impl_->held[source_session];
    have.durable = std::max(have.durable, std::min(sequence, have.received));
    impl_->unsaid_acks.insert(source_session);
  }
  impl_->wake.notify();
}

void CaptureReceiver::refuse(const std::string& source_session, const std::string& reason) {
  {
    const std::lock_guard lock(impl_->mutex);
    if (!impl_->refused.insert({source_session, "source_session: " + reason}).second) return;
    impl_->stats.last_error = impl_->unsaid_refusal = sayable(reason);
    impl_->unsaid_credits += static_cast<std::uint32_t>(std::erase_if(impl_->queue, [&](const Received& waiting) {
      return !waiting.live && waiting.capture.source_session == source_session;
    }));
  }
  impl_->wake.notify();
}

ReceiverStats CaptureReceiver::stats() const {
  const std::lock_guard lock(impl_->mutex);
  ReceiverStats stats = impl_->stats;
  stats.ended = stats.ended && impl_->queue.empty();
  stats.connected = stats.connected && Clock::now() - impl_->heard < kSilence;
  return stats;
}

}  // namespace sheen
