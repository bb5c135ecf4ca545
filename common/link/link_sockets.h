// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/link/message_type.h"
#include "common/link/transport_internals.h"

// The two sockets of the data link, each with what happens to its connections. Each can be closed and opened again,
// which is the only way in which the library lets go of a connection and of what waits from it.
namespace sheen {

using MessageParts = std::vector<zmq::message_t>;
MessageParts parts_of(MessageType type, const Bytes& body);
/// They share the bytes instead of copying them.
MessageParts parts_of(const std::shared_ptr<const EncodedCapture>& capture);

/// The tracker's: a ROUTER that is bound.
class RouterSocket {
 public:
  enum class Sent { kYes, kLater, kUnreachable };
  /// Throws DeviceError.
  RouterSocket(zmq::context_t& context, const std::string& endpoint, const CurveKeys* keys);
  ~RouterSocket();

  const std::string& endpoint() const { return endpoint_; }  ///< with its port
  void* socket();
  void* events();
  /// What happened since the last call.
  std::vector<SocketEvents::Kind> drain();
  bool receive(MessageParts& parts);
  Sent send(const std::string& id, MessageParts parts);

  int connections() const { return connections_; }  ///< that are open, also those that nobody hears any more
  bool is_open() const { return socket_ != nullptr; }
  /// Closes all connections. Nothing but `is_open` and `open_again` may be called next.
  void close();
  void open_again();  ///< throws DeviceError

 private:
  void open(const std::string& endpoint);

  zmq::context_t& context_;
  const CurveKeys* keys_;
  std::string endpoint_;
  std::unique_ptr<zmq::socket_t> socket_;
  std::unique_ptr<SocketEvents> events_;
  int opened_ = 0, connections_ = 0;
};

/// The reconstructor's: a DEALER that calls, and calls again.
class DealerSocket {
 public:
  DealerSocket(zmq::context_t& context, const ReceiverOptions& options);
  ~DealerSocket();

  void open_again();
  void* socket();
  void* events();
  std::vector<SocketEvents::Kind> drain() { return events_->drain(); }
  bool receive(MessageParts& parts);
  bool send(MessageType type, const Bytes& body);  ///< false: later
  void close_with_last_words(std::chrono::milliseconds patience);

 private:
  zmq::context_t& context_;
  const ReceiverOptions& options_;
  const std::string routing_id_;
  std::unique_ptr<zmq::socket_t> socket_;
  std::unique_ptr<SocketEvents> events_;
  int opened_ = 0;
};

}  // namespace sheen
