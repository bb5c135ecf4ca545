// SPDX-License-Identifier: Apache-2.0
// Baselines that mean harm, on every socket: valid messages that were changed, in any order, too large, or about what
// never was. Each end goes on, its memory stays bounded, what it refuses it counts by name, and an honest peer that
// comes afterwards gets what it would have got. tests/loopback/attack runs the same for longer.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <deque>
#include <fstream>
#include <iostream>
#include <random>

#include "common/base/errors.h"
#include "common/capture/capture_validation.h"
#include "common/link/monitor_socket.h"
#include "reconstructor/monitor/monitor_server.h"
#include "tests/support/link.h"

namespace sheen::testing {
namespace {

using namespace std::chrono_literals;
using Message = std::vector<Bytes>;

/// Hostile messages in all; a page or a subscription takes longer than a message, and gets fewer.
int messages(int share_percent) {
  const char* wanted = std::getenv("SHEEN_ATTACK_MESSAGES");
  return (wanted ? std::atoi(wanted) : 4000) / 100 * share_percent;
}

std::size_t resident_bytes() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// Fails the test where memory grows beyond what caches, queues and a sanitizer's quarantine take.
class MemoryWatch {
 public:
  void sample() { most_ = std::max(most_, resident_bytes()); }
  ~MemoryWatch() {
    sample();
    const std::size_t grown = (most_ - std::min(most_, before_)) >> 20;
    std::cout << "memory: " << (before_ >> 20) << " MB before, at most " << grown << " MB more\n";
    EXPECT_LT(grown, 700u);
  }

 private:
  std::size_t before_ = resident_bytes(), most_ = before_;
};

/// Turns valid messages into ones that are not, or not now.
class Forger {
 public:
  explicit Forger(unsigned seed) : random_(seed) {}

  Message forge(const std::vector<Message>& valid) {
    Message message = valid[pick(valid.size())];
    Bytes& part = message[pick(message.size())];
    switch (pick(8)) {
      case 0:
        for (std::size_t n = 1 + pick(4); n > 0 && !part.empty(); --n) part[pick(part.size())] = byte();
        break;
      case 1:
        part.resize(pick(part.size() + 1));
        break;
      case 2:
        part.insert(part.begin() + static_cast<std::ptrdiff_t>(pick(part.size() + 1)), 1 + pick(20), byte());
        break;
      case 3:
        message.pop_back();
        if (message.empty()) message.emplace_back();
        break;
      case 4:
        message.push_back(part);
        break;
      case 5:
        std::swap(part, message.back());
        break;
      case 6:
        part.assign(pick(pick(100) == 0 ? 2'000'000 : 2'000), byte());
        break;
      default:
        break;  // valid, but out of its turn
    }
    return message;
  }
  std::size_t pick(std::size_t below) { return std::uniform_int_distribution<std::size_t>(0, below - 1)(random_); }
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_()); }

 private:
  std::mt19937 random_;
};

template <typename T>
Message message_of(MessageType type, const T& body) {
  const auto envelope = encode_envelope(type);
  return {Bytes(envelope.begin(), envelope.end()), encode(body)};
}
Message message_of(const EncodedCapture& m) {
  return {m.envelope, m.header, m.blob};
}
Message kept(std::uint64_t sequence) {
  return message_of(encode_capture(sample_capture("s", sequence), MessageType::kKeep, Codec::kRaw));
}

/// 36 MB of pixels in about a kilobyte.
Message bomb() {
  Capture capture = sample_capture("s", 1);
  capture.image = {.format = PixelFormat::kMono8, .width = 6000, .height = 6000, .stride = 6000};
  capture.image.bytes.resize(36'000'000);
  capture.camera.width = capture.camera.height = 6000;
  return message_of(encode_capture(capture, MessageType::kLive, Codec::kDeltaZstd));
}

/// False when the other end has hung up, and is not back yet.
bool try_send(RawPeer& peer, const Message& message) {
  try {
    return peer.send(message);
  } catch (const zmq::error_t&) {
    return false;
  }
}

void expect_refusals_named(const ReceiverStats& stats) {
  std::uint64_t named = 0;
  for (const auto& [reason, count] : stats.rejected_by_reason) {
    EXPECT_FALSE(reason.empty());
    named += count;
  }
  EXPECT_EQ(named, stats.rejected_messages);
  EXPECT_LT(stats.rejected_by_reason.size(), 200u) << "what a stranger says must not become a reason";
}

/// A sender played by the test. It welcomes whoever says hello.
struct HostileSender : RawPeer {
  HostileSender() : RawPeer(zmq::socket_type::router) {
    socket.set(zmq::sockopt::router_mandatory, true);  // nothing is dropped on the way: it waits, or knows
    socket.set(zmq::sockopt::sndtimeo, 1000);
    socket.set(zmq::sockopt::rcvtimeo, 0);
    socket.bind(kAnyPort);
  }
  std::string endpoint() { return socket.get(zmq::sockopt::last_endpoint); }
  void welcome_hellos() {
    for (Message parts = receive(); !parts.empty(); parts = receive()) {
      if (decode_envelope(parts[0]).type != MessageType::kHello) continue;
      const Hello hello = decode_hello(parts[1]);
      const auto held = hello.held.find("s");
      received = held == hello.held.end() ? 0 : held->second.received;
      say(MessageType::kWelcome, Welcome{"s", 1, hello.clock_ns, hello.clock_ns});
    }
  }
  std::uint64_t received = 0;  ///< of "s", as the latest hello said
};

TEST(Attack, OnAReceiver) {
  HostileSender peer;
  CaptureReceiver receiver(receiver_options(peer.endpoint()));
  const std::vector<Message> valid{
      kept(1),
      kept(2),
      kept(7),
      message_of(encode_capture(sample_capture("s", 3), MessageType::kLive, Codec::kRaw)),
      message_of(encode_capture(sample_capture("t", 1), MessageType::kKeep, Codec::kDeltaZstd)),
      message_of(MessageType::kWelcome, Welcome{"s", std::uint64_t{1} << 63, 1, 1}),
      message_of(MessageType::kEnd, End{"s", ~0ull}),
      message_of(MessageType::kRefuse, Refuse{"go away"}),
      message_of(MessageType::kAck, Ack{"s", 1, true})};
  const Message too_dense = bomb();
  Forger forger(1);
  std::map<std::string, std::uint64_t> last;
  const auto take_all = [&] {
    while (const auto got = receiver.next(0ms)) {
      ASSERT_EQ(validation_error(got->capture), "");
      if (got->live) continue;
      ASSERT_EQ(got->capture.sequence, ++last[got->capture.source_session]) << "out of its turn";
    }
  };
  const auto counted = [&] {
    take_all();
    const ReceiverStats stats = receiver.stats();
    return stats.rejected_messages + stats.kept + stats.live + stats.duplicates;
  };
  const int all = messages(40);
  int sent = 0;
  MemoryWatch memory;
  while (sent < all) {
    peer.welcome_hellos();
    const std::uint64_t before = counted();
    for (int i = 0; i < 50; ++i) sent += try_send(peer, forger.pick(1000) == 0 ? too_dense : forger.forge(valid));
    // Few are on their way at a time: those are lost when a connection breaks.
    for (int wait = 0; wait < 200 && counted() < before + 25; ++wait) std::this_thread::sleep_for(1ms);
    memory.sample();
  }
  EXPECT_TRUE(eventually([&] { return peer.welcome_hellos(), counted() > static_cast<std::uint64_t>(sent) / 2; }))
      << counted() << " of " << sent;
  expect_refusals_named(receiver.stats());
  std::cout << sent << " messages, " << receiver.stats().rejected_messages << " refused, "
            << receiver.stats().rejected_by_reason.size() << " reasons\n";

  // An honest sender in its place: what comes next in its turn is taken as ever.
  const std::uint64_t next = last["s"] + 1;
  EXPECT_TRUE(eventually([&] {
    peer.welcome_hellos();
    try_send(peer, kept(next));
    const auto got = receiver.next(50ms);
    return got && !got->live && got->capture.sequence == next && got->capture.image == sample_capture("s", next).image;
  })) << receiver.stats().last_error;
}

TEST(Attack, OnASender) {
  constexpr std::uint64_t kKept = 20;
  CaptureSender sender(sender_options());
  keep(sender, 1, kKept);
  std::vector<Message> valid{message_of(MessageType::kHello, Hello{"reconstructor", 0, {}, 1}),
                             message_of(MessageType::kHello, Hello{"reconstructor", ~0u, {{"t", {9, 9}}}, 1}),
                             message_of(MessageType::kHello, Hello{"reconstructor", 1, {{"s", {~0ull, ~0ull}}}, 1}),
                             message_of(MessageType::kCredit, Credit{1}),
                             message_of(MessageType::kCredit, Credit{~0u}),
                             message_of(MessageType::kEnd, End{"s", 1}),
                             kept(1)};
  for (const std::uint64_t durable :
       {std::uint64_t{1}, kKept + 1, std::uint64_t{1'000'000}, std::uint64_t{1} << 63, ~std::uint64_t{0}})
    valid.push_back(message_of(MessageType::kAck, Ack{"s", durable, true}));
  {
    const auto call = [&] {
      auto peer = std::make_unique<RawPeer>(zmq::socket_type::dealer);
      peer->socket.set(zmq::sockopt::rcvtimeo, 0);
      peer->socket.set(zmq::sockopt::sndtimeo, 200);
      peer->socket.connect(sender.endpoint());
      return peer;
    };
    std::unique_ptr<RawPeer> peer = call();
    int calls = 1;
    Forger forger(2);
    const int all = messages(40);
    int sent = 0;
    MemoryWatch memory;
    while (sent < all) {
      for (int i = 0; i < 50; ++i) {
        if (try_send(*peer, forger.forge(valid))) {
          ++sent;
        } else {  // what the sender hung up on does not always call again by itself
          peer = call();
          ++calls;
        }
      }
      while (!peer->receive().empty()) {
      }
      memory.sample();
    }
    EXPECT_TRUE(eventually([&] { return sender.stats().rejected_messages > static_cast<std::uint64_t>(sent) / 4; }))
        << sender.stats().rejected_messages << " of " << sent;
    EXPECT_FALSE(sender.stats().last_refusal.empty());
    std::cout << sent << " messages in " << calls << " connections, " << sender.stats().rejected_messages
              << " refused\n";
  }

  // What it really sent to the stranger, the stranger could acknowledge. All else an honest receiver gets. That the
  // stranger left is seen after all that it said.
  EXPECT_TRUE(eventually([&] { return !sender.stats().peer_connected; }));
  const std::uint64_t taken = sender.stats().delivered;
  keep(sender, kKept + 1, kKept + 3);
  CaptureReceiver receiver(receiver_options(sender.endpoint()));
  std::optional<Received> got = receiver.next(kLong);
  ASSERT_TRUE(got) << receiver.stats().last_error;
  EXPECT_LE(got->capture.sequence, taken + 1);
  EXPECT_LE(receiver.stats().missing, taken);
  receiver.acknowledge("s", got->capture.sequence);
  expect_kept(receiver, got->capture.sequence + 1, kKept + 3);
  EXPECT_TRUE(sender.finish(kLong));
}

Status status() {
  Status status{.role = "tracker", .source_session = "s", .state = SourceState::kLive, .message = "fine"};
  status.gauges = {{"link_acknowledged", 3}, {"frames", 5}};
  status.preview_jpeg.assign(1000, 7);
  return status;
}

TEST(Attack, OnAWatcher) {
  zmq::context_t context{1};
  zmq::socket_t publisher(context, zmq::socket_type::pub);
  publisher.set(zmq::sockopt::linger, 0);
  publisher.bind(kAnyPort);
  MonitorSubscriber watcher({.endpoint = publisher.get(zmq::sockopt::last_endpoint)});
  const Message valid{encode_status(status())};
  const auto say = [&](const Message& message) {
    for (std::size_t i = 0; i < message.size(); ++i)
      publisher.send(zmq::buffer(message[i]),
                     i + 1 < message.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
  };
  const auto sees_what_is_valid = [&] {
    return eventually([&] {
      say(valid);
      const auto seen = watcher.next(20ms);
      return seen && seen->message == "fine";
    });
  };
  ASSERT_TRUE(sees_what_is_valid()) << watcher.stats().last_error;
  Forger forger(3);
  const int all = messages(18);
  MemoryWatch memory;
  for (int sent = 0; sent < all; ++sent) {
    say(forger.forge({valid}));
    if (sent % 4 == 0) watcher.next(1ms);
    if (sent % 256 == 0) memory.sample();
  }
  EXPECT_GT(watcher.stats().rejected, 0u);
  EXPECT_FALSE(watcher.stats().last_error.empty());
  std::cout << all << " messages, " << watcher.stats().rejected << " looked at and refused\n";
  EXPECT_TRUE(sees_what_is_valid()) << watcher.stats().last_error;
}

TEST(Attack, OnAPublisher) {
  MonitorPublisher publisher({.endpoint = kAnyPort});
  MonitorSubscriber watcher({.endpoint = publisher.endpoint()});
  zmq::context_t context{1};
  zmq::socket_t stranger(context, zmq::socket_type::xsub);  // says to a publisher what it likes
  stranger.set(zmq::sockopt::linger, 0);
  stranger.set(zmq::sockopt::sndtimeo, 1000);
  stranger.connect(publisher.endpoint());
  Forger forger(4);
  const int all = messages(1);
  MemoryWatch memory;
  for (int sent = 0; sent < all; ++sent) {
    const Message subscription = forger.forge({{Bytes{1, forger.byte(), forger.byte(), forger.byte()}}, {Bytes{0}}});
    stranger.send(zmq::buffer(subscription[0]), zmq::send_flags::none);
    if (sent % 16 == 0) publisher.publish(status());
    if (sent % 256 == 0) memory.sample();
  }
  EXPECT_TRUE(eventually([&] {
    publisher.publish(status());
    return watcher.next(20ms).has_value();
  }));
}

/// A TCP connection to the status page.
class Visitor {
 public:
  explicit Visitor(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval patience{kPatienceFactor, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) hang_up();
  }
  ~Visitor() { hang_up(); }
  Visitor(const Visitor&) = delete;
  Visitor& operator=(const Visitor&) = delete;

  /// What is answered to it, as far as it comes within the patience.
  std::string ask(const std::string& text) const {
    (void)!::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
    std::string answer(1 << 16, '\0');
    const auto size = ::recv(socket_, answer.data(), answer.size(), 0);
    answer.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    return answer;
  }
  void say(const std::string& text) const { (void)!::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }

 private:
  void hang_up() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }
  int socket_;
};

TEST(Attack, OnThePage) {
  MonitorServer server({.port = 0});
  server.publish({});
  const std::string end = "\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n", first = "GET /status.json HTTP/1.1";
  std::string ranges = first + "\r\nRange: bytes=0-";
  for (int i = 0; i < 1500; ++i) ranges += ",0-";
  std::vector<Message> valid;
  for (const std::string& request :
       {first + end, "GET /preview.jpg?token=x HTTP/1.1" + end, "POST / HTTP/1.1\r\nContent-Length: 99999999999" + end,
        "POST / HTTP/1.1\r\nTransfer-Encoding: chunked" + end + "fffffffff\r\n", ranges + end,
        "GET /" + std::string(100'000, 'a') + " HTTP/1.1" + end, first + "\r\nA: " + std::string(100'000, 'b') + end})
    valid.push_back({Bytes(request.begin(), request.end())});
  Forger forger(5);
  const int all = messages(1);
  {
    MemoryWatch memory;
    std::deque<std::unique_ptr<Visitor>> silent;  // those that never finish what they say, and stay
    for (int sent = 0; sent < all; ++sent) {
      const Message request = forger.forge(valid);
      const std::string text(request[0].begin(), request[0].end());
      auto visitor = std::make_unique<Visitor>(server.port());
      visitor->say(text.substr(0, sent % 8 == 0 ? forger.pick(text.size() + 1) : text.size()));
      if (sent % 8 == 0) silent.push_back(std::move(visitor));
      if (silent.size() > 30) silent.pop_front();
      memory.sample();
    }
  }
  EXPECT_TRUE(eventually([&] {
    server.publish({});  // one that has said nothing for seconds is called stalled, with status 503
    return Visitor(server.port()).ask("GET /healthz HTTP/1.1" + end).starts_with("HTTP/1.1 200");
  }));
}

}  // namespace
}  // namespace sheen::testing
