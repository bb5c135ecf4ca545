// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "common/link/transport.h"
#include "common/link/wire_messages.h"
#include "tests/support/patience.h"
#include "tests/support/sample_capture.h"

namespace sheen::testing {

inline constexpr std::chrono::seconds kLong{
    10 * kPatienceFactor};  // nobody waits as long as this unless something is broken
inline constexpr const char* kAnyPort = "tcp://127.0.0.1:*";

inline SenderOptions sender_options(const std::string& endpoint = kAnyPort, const std::string& session = "s") {
  SenderOptions options;
  options.endpoint = endpoint;
  options.source_session = session;
  return options;
}

inline ReceiverOptions receiver_options(const std::string& endpoint) {
  ReceiverOptions options;
  options.endpoint = endpoint;
  return options;
}

inline bool eventually(const std::function<bool()>& holds) {
  for (const auto end = std::chrono::steady_clock::now() + kLong; std::chrono::steady_clock::now() < end;) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

/// An address that was free a moment ago.
inline std::string free_endpoint() {
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::rep);
  socket.bind(kAnyPort);
  return socket.get(zmq::sockopt::last_endpoint);
}

inline void keep(CaptureSender& sender, std::uint64_t first, std::uint64_t last, const std::string& session = "s") {
  for (std::uint64_t sequence = first; sequence <= last; ++sequence)
    ASSERT_TRUE(sender.keep(sample_capture(session, sequence), kLong));
}

/// Takes kept captures, acknowledges each, and expects them to be first..last in order and unharmed.
inline void expect_kept(CaptureReceiver& receiver, std::uint64_t first, std::uint64_t last, bool acknowledge = true,
                        const std::string& session = "s") {
  for (std::uint64_t sequence = first; sequence <= last; ++sequence) {
    const auto got = receiver.next(kLong);
    ASSERT_TRUE(got) << "capture " << sequence << " did not come: " << receiver.stats().last_error;
    ASSERT_FALSE(got->live);
    ASSERT_EQ(got->capture.sequence, sequence);
    ASSERT_EQ(got->capture.image, sample_capture(session, sequence).image);
    if (acknowledge) receiver.acknowledge(session, sequence);
  }
}

/// One end of the data link that says exactly what a test tells it to: a DEALER that connects, or a ROUTER that is
/// bound and answers whoever spoke last.
class RawPeer {
 public:
  explicit RawPeer(zmq::socket_type type) : is_router_(type == zmq::socket_type::router), socket(context, type) {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::rcvtimeo, static_cast<int>(std::chrono::milliseconds(kLong).count()));
  }

  /// False when it took longer than the socket waits.
  bool send(const std::vector<Bytes>& parts) {
    if (is_router_ && !socket.send(zmq::buffer(partner_), zmq::send_flags::sndmore)) return false;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (!socket.send(zmq::buffer(parts[i]), i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none))
        return false;
    return true;
  }
  template <typename Message>
  void say(MessageType type, const Message& message, std::uint16_t major = kWireMajor) {
    const auto envelope = encode_envelope(type);
    Bytes bytes(envelope.begin(), envelope.end());
    bytes[4] = static_cast<std::uint8_t>(major);
    send({bytes, encode(message)});
  }
  void say(const EncodedCapture& m) { send({m.envelope, m.header, m.blob}); }

  /// The parts of the next message, without the routing id; none when nothing comes.
  std::vector<Bytes> receive() {
    std::vector<Bytes> parts;
    for (bool more = true, first = true; more; first = false) {
      zmq::message_t part;
      if (!socket.recv(part)) return {};
      more = part.more();
      if (is_router_ && first)
        partner_ = part.to_string();
      else
        parts.emplace_back(part.data<std::uint8_t>(), part.data<std::uint8_t>() + part.size());
    }
    return parts;
  }
  /// Skips messages until one of this type comes, and returns its parts.
  std::vector<Bytes> receive(MessageType type) {
    for (;;) {
      const std::vector<Bytes> parts = receive();
      if (parts.empty() || decode_envelope(parts[0]).type == type) return parts;
    }
  }

 private:
  zmq::context_t context{1};
  bool is_router_;
  std::string partner_;

 public:
  zmq::socket_t socket;
};

}  // namespace sheen::testing
