// SPDX-License-Identifier: Apache-2.0
#include "common/link/monitor_socket.h"

#include <array>
#include <mutex>
#include <thread>
#include <utility>
#include <zmq.hpp>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/link/transport_internals.h"
#include "common/link/wire_messages.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kIdle{500};
constexpr int kBufferedForSubscriber = 4;
constexpr int kBufferedBySubscriber = 64;         // overtaken ones: it reads them all for the newest
constexpr std::int64_t kMaxIncomingBytes = 1024;  // subscribers only subscribe
constexpr milliseconds kReopenAfter{5000};        // the library gives up after a refused handshake

}  // namespace

struct MonitorPublisher::Impl {
  explicit Impl(const PublisherOptions& options);
  void run(const std::stop_token& stop);
  void round();
  void send_newest();

  zmq::context_t context{1};
  std::unique_ptr<ZapHandler> zap;
  zmq::socket_t socket;
  Wakeup wake;
  std::string endpoint;

  mutable std::mutex mutex;  // guards everything below
  std::optional<Status> newest;
  std::uint64_t sequence = 0;
  SparingLog refusals{"link"};
  PublisherStats stats;

  std::jthread io;  // last: stops before what it uses is gone
};

MonitorPublisher::Impl::Impl(const PublisherOptions& options) : socket(context, zmq::socket_type::pub) {
  require_keys_beyond_loopback(options.endpoint, options.keys.has_value());
  set_common_options(socket);
  socket.set(zmq::sockopt::sndhwm, kBufferedForSubscriber);
  socket.set(zmq::sockopt::maxmsgsize, kMaxIncomingBytes);
  if (options.keys) {
    if (options.allowlist.empty()) throw ConfigError("allowlist: with keys, name the file of those that may watch");
    zap = std::make_unique<ZapHandler>(context, options.allowlist, std::set<std::string>{"monitor", "reconstructor"});
    set_curve_server(socket, *options.keys);
  }
  endpoint = bind_endpoint(socket, options.endpoint);
  io = guarded_thread([this](const std::stop_token& stop) { run(stop); },
                      [this](const std::exception_ptr& error) { refusals.tell("thread", words_of(error)); });
}

void MonitorPublisher::Impl::run(const std::stop_token& stop) {
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

void MonitorPublisher::Impl::round() {
  // Looking whether the socket has something, which it never has, makes it take the subscriptions that wait.
  std::array<zmq::pollitem_t, 3> items{{{nullptr, wake.fd(), ZMQ_POLLIN, 0},
                                        {socket.handle(), 0, ZMQ_POLLIN, 0},
                                        {zap ? zap->socket() : nullptr, 0, ZMQ_POLLIN, 0}}};
  zmq::poll(items.data(), zap ? 3 : 2, kIdle);
  wake.drain();
  if (zap) {
    const std::lock_guard lock(mutex);
    zap->answer(refusals);
    stats.refused_keys = zap->refused();
    stats.last_refusal = zap->last_refusal();
  }
  send_newest();
}

void MonitorPublisher::Impl::send_newest() {
  std::optional<Status> status;
  {
    const std::lock_guard lock(mutex);
    status = std::exchange(newest, std::nullopt);
  }
  if (!status) return;
  Bytes message = encode_status(*status);
  const bool too_large = message.size() > kMaxStatusBytes;
  if (too_large) {
    status->preview_jpeg.clear();
    message = encode_status(*status);
  }
  socket.send(zmq::buffer(message), zmq::send_flags::dontwait);
  const std::lock_guard lock(mutex);
  ++stats.published;
  stats.previews_dropped += too_large;
}

MonitorPublisher::MonitorPublisher(const PublisherOptions& options) : impl_(std::make_unique<Impl>(options)) {}
MonitorPublisher::~MonitorPublisher() = default;

void MonitorPublisher::publish(Status status) {
  {
    const std::lock_guard lock(impl_->mutex);
    status.sequence = ++impl_->sequence;
    status.clock_ns = steady_now_ns();
    if (impl_->newest) ++impl_->stats.replaced;
    impl_->newest = std::move(status);
  }
  impl_->wake.notify();
}

std::string MonitorPublisher::endpoint() const {
  return impl_->endpoint;
}

PublisherStats MonitorPublisher::stats() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->stats;
}

struct MonitorSubscriber::Impl {
  explicit Impl(const SubscriberOptions& subscriber_options) : options(subscriber_options) {
    require_keys_beyond_loopback(options.endpoint, options.keys.has_value());
    open();
  }

  void open() {
    socket.emplace(context, zmq::socket_type::sub);
    set_common_options(*socket);
    // Not ZMQ_CONFLATE: with it, the library ends the process when a message of several parts comes.
    socket->set(zmq::sockopt::rcvhwm, kBufferedBySubscriber);
    socket->set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(kMaxStatusBytes));
    if (options.keys) set_curve_client(*socket, *options.keys, options.server_public_key);
    connect_endpoint(*socket, options.endpoint);
    socket->set(zmq::sockopt::subscribe, "");
    last_activity = Clock::now();
  }

  /// The newest status of those that wait; nothing when there is none.
  std::optional<Status> receive() {
    std::optional<Status> newest;
    std::vector<zmq::message_t> parts;
    for (int i = 0; i < 2 * kBufferedBySubscriber && receive_parts(*socket, 1, parts); ++i) {
      last_activity = Clock::now();
      try {
        if (parts.size() != 1) throw ProtocolError("message: has the wrong number of parts");
        newest = decode_status({parts[0].data<std::uint8_t>(), parts[0].size()});
        ++stats.received;
      } catch (const ProtocolError& error) {
        ++stats.rejected;
        stats.last_error = error.what();
      }
    }
    return newest;
  }

  const SubscriberOptions options;
  zmq::context_t context{1};
  std::optional<zmq::socket_t> socket;
  Clock::time_point last_activity;
  SubscriberStats stats;
};

MonitorSubscriber::MonitorSubscriber(const SubscriberOptions& options) : impl_(std::make_unique<Impl>(options)) {}
MonitorSubscriber::~MonitorSubscriber() = default;

std::optional<Status> MonitorSubscriber::next(milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  for (;;) {
    if (auto status = impl_->receive()) return status;
    const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
    if (left <= milliseconds::zero()) return std::nullopt;
    zmq_pollitem_t item{impl_->socket->handle(), 0, ZMQ_POLLIN, 0};
    zmq_poll(&item, 1, std::min(left, kIdle).count());  // a signal ends it early: look again
    if (Clock::now() - impl_->last_activity > kReopenAfter) impl_->open();
  }
}

SubscriberStats MonitorSubscriber::stats() const {
  return impl_->stats;
}

}  // namespace sheen
