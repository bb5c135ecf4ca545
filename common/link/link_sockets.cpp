// SPDX-License-Identifier: Apache-2.0
#include "common/link/link_sockets.h"

#include <algorithm>
#include <random>
#include <thread>
#include <zmq.hpp>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr std::size_t kMostParts = 3;
constexpr std::int64_t kMostBytesFromReceiver = 1 << 20;  // it only says short things
constexpr std::int64_t kMostBytesFromSender = std::int64_t(300) << 20;
constexpr std::chrono::milliseconds kRebindPause{5};
constexpr int kRebindAttempts = 100;

/// The same for the life of a receiver, so that a sender knows it again after a reconnect.
std::string random_routing_id() {
  std::random_device random;
  std::string id = "r";
  for (int i = 0; i < 16; ++i) id += "0123456789abcdef"[random() % 16];
  return id;
}

zmq::message_t shared_part(const std::shared_ptr<const EncodedCapture>& owner, const std::vector<std::uint8_t>& bytes) {
  using Owner = std::shared_ptr<const EncodedCapture>;
  auto hint = std::make_unique<Owner>(owner);
  zmq::message_t part(
      const_cast<std::uint8_t*>(bytes.data()), bytes.size(), [](void*, void* h) { delete static_cast<Owner*>(h); },
      hint.get());
  hint.release();
  return part;
}

}  // namespace

MessageParts parts_of(MessageType type, const Bytes& body) {
  const auto envelope = encode_envelope(type);
  MessageParts parts;
  parts.emplace_back(envelope.data(), envelope.size());
  parts.emplace_back(body.data(), body.size());
  return parts;
}

MessageParts parts_of(const std::shared_ptr<const EncodedCapture>& capture) {
  MessageParts parts;
  for (const auto* bytes : {&capture->envelope, &capture->header, &capture->blob})
    parts.push_back(shared_part(capture, *bytes));
  return parts;
}

RouterSocket::RouterSocket(zmq::context_t& context, const std::string& endpoint, const CurveKeys* keys)
    : context_(context), keys_(keys) {
  open(endpoint);
}

RouterSocket::~RouterSocket() = default;

void RouterSocket::open(const std::string& endpoint) {
  socket_ = std::make_unique<zmq::socket_t>(context_, zmq::socket_type::router);
  set_common_options(*socket_);
  socket_->set(zmq::sockopt::router_mandatory, true);
  socket_->set(zmq::sockopt::router_handover, true);
  socket_->set(zmq::sockopt::maxmsgsize, kMostBytesFromReceiver);
  if (keys_) set_curve_server(*socket_, *keys_);
  events_ = std::make_unique<SocketEvents>(context_, *socket_, "sender-" + std::to_string(opened_++));
  endpoint_ = bind_endpoint(*socket_, endpoint);
  connections_ = 0;
}

void RouterSocket::close() {
  events_.reset();
  socket_.reset();
}

void RouterSocket::open_again() {
  for (int attempt = 1;; ++attempt) {  // the library frees the address a moment after the socket that had it is closed
    try {
      return open(std::string(endpoint_));
    } catch (const DeviceError&) {
      close();
      if (attempt == kRebindAttempts) throw;
    }
    std::this_thread::sleep_for(kRebindPause);
  }
}

void* RouterSocket::socket() {
  return socket_->handle();
}

void* RouterSocket::events() {
  return events_->socket();
}

std::vector<SocketEvents::Kind> RouterSocket::drain() {
  const std::vector<SocketEvents::Kind> happened = events_->drain();
  for (const SocketEvents::Kind kind : happened)
    connections_ += (kind == SocketEvents::Kind::kAccepted) - (kind == SocketEvents::Kind::kDisconnected);
  return happened;
}

bool RouterSocket::receive(MessageParts& parts) {
  return receive_parts(*socket_, kMostParts, parts);
}

RouterSocket::Sent RouterSocket::send(const std::string& id, MessageParts parts) {
  try {
    if (!socket_->send(zmq::buffer(id), zmq::send_flags::dontwait | zmq::send_flags::sndmore)) return Sent::kLater;
    for (std::size_t i = 0; i < parts.size(); ++i)
      socket_->send(parts[i], i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
    return Sent::kYes;
  } catch (const zmq::error_t&) {  // EHOSTUNREACH: the connection is gone
    return Sent::kUnreachable;
  }
}

DealerSocket::DealerSocket(zmq::context_t& context, const ReceiverOptions& options)
    : context_(context), options_(options), routing_id_(random_routing_id()) {
  open_again();
}

DealerSocket::~DealerSocket() = default;

void DealerSocket::open_again() {
  events_.reset();
  socket_ = std::make_unique<zmq::socket_t>(context_, zmq::socket_type::dealer);
  set_common_options(*socket_);
  socket_->set(zmq::sockopt::routing_id, routing_id_);
  socket_->set(zmq::sockopt::immediate, true);  // nothing is queued for a sender that is not there
  socket_->set(zmq::sockopt::maxmsgsize, kMostBytesFromSender);
  if (options_.keys) set_curve_client(*socket_, *options_.keys, options_.server_public_key);
  events_ = std::make_unique<SocketEvents>(context_, *socket_, "receiver-" + std::to_string(opened_++));
  connect_endpoint(*socket_, options_.endpoint);
}

void* DealerSocket::socket() {
  return socket_->handle();
}

void* DealerSocket::events() {
  return events_->socket();
}

bool DealerSocket::receive(MessageParts& parts) {
  return receive_parts(*socket_, kMostParts, parts);
}

bool DealerSocket::send(MessageType type, const Bytes& body) {
  if (!socket_->send(zmq::buffer(encode_envelope(type)), zmq::send_flags::dontwait | zmq::send_flags::sndmore))
    return false;
  socket_->send(zmq::buffer(body), zmq::send_flags::none);
  return true;
}

void DealerSocket::close_with_last_words(std::chrono::milliseconds patience) {
  events_.reset();
  socket_->set(zmq::sockopt::linger, static_cast<int>(patience.count()));
}

}  // namespace sheen
