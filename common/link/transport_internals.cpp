// SPDX-License-Identifier: Apache-2.0
#include "common/link/transport_internals.h"

#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <sstream>
#include <utility>
#include <zmq.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/link/endpoint.h"

namespace sheen {
namespace {

constexpr const char* kZapEndpoint = "inproc://zeromq.zap.01";
constexpr std::uintmax_t kMaxAllowlistBytes = 1 << 20;

/// Changes whenever the file is replaced or written to.
std::string stamp_of(const std::filesystem::path& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return "missing";
  std::ostringstream stamp;
  stamp << info.st_ino << ' ' << info.st_size << ' ' << info.st_mtim.tv_sec << ' ' << info.st_mtim.tv_nsec;
  return stamp.str();
}

std::string host_of(const std::string& endpoint) {
  constexpr std::string_view kTcp = "tcp://";
  if (!endpoint.starts_with(kTcp)) return {};
  const std::size_t port = endpoint.rfind(':');
  return endpoint.substr(kTcp.size(), port - kTcp.size());
}

bool is_loopback(const std::string& endpoint) {
  if (endpoint.starts_with("ipc://") || endpoint.starts_with("inproc://")) return true;
  const std::string host = host_of(endpoint);
  return host == "[::1]" || (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

/// Of the ways in which a handshake can break the protocol, those of a peer whose keys do not fit.
bool is_about_keys(std::uint32_t protocol_error) {
  return protocol_error == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH ||
         protocol_error == ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC ||
         protocol_error == ZMQ_PROTOCOL_ERROR_ZMTP_KEY_EXCHANGE;
}

}  // namespace

void require_keys_beyond_loopback(const std::string& written, bool has_keys) {
  const std::string endpoint = resolved_endpoint(written);
  if (!has_keys && !is_loopback(endpoint))
    throw ConfigError("endpoint " + endpoint +
                      ": other machines can reach it, so it needs keys; make them with sheen-tracker keygen, or use "
                      "tcp://127.0.0.1:PORT");
}

Allowlist::Allowlist(std::filesystem::path path) : path_(std::move(path)) {
  load();
  if (!error_.empty()) throw ConfigError(error_);
}

void Allowlist::load() {
  stamp_ = stamp_of(path_);
  error_.clear();
  std::map<std::string, AllowedPeer> peers;
  try {
    std::istringstream text(read_file(path_, kMaxAllowlistBytes));
    std::string line;
    for (int number = 1; std::getline(text, line); ++number) {
      std::istringstream words(line.substr(0, line.find(" #")));
      std::string key;
      AllowedPeer peer;
      if (!(words >> key) || (key[0] == '#' && !is_z85_key(key))) continue;
      if (!is_z85_key(key) || !(words >> peer.role))
        throw FileError(path_, "line " + std::to_string(number) + ": must be KEY role name");
      words >> peer.name;
      peers[key] = peer;
    }
    peers_ = std::move(peers);
  } catch (const FileError& error) {
    peers_.clear();
    error_ = std::string("allowlist ") + error.what();
  }
}

std::optional<AllowedPeer> Allowlist::find(const std::string& public_key) {
  if (stamp_of(path_) != stamp_) load();
  const auto found = peers_.find(public_key);
  if (found == peers_.end()) return std::nullopt;
  return found->second;
}

Wakeup::Wakeup() : fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_ < 0) throw DeviceError(std::string("eventfd: ") + std::strerror(errno));
}
Wakeup::~Wakeup() {
  ::close(fd_);
}
void Wakeup::notify() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t n = ::write(fd_, &one, sizeof one);  // full means that it is set already
}
void Wakeup::drain() {
  std::uint64_t count;
  [[maybe_unused]] const ssize_t n = ::read(fd_, &count, sizeof count);
}

ZapHandler::ZapHandler(zmq::context_t& context, const std::filesystem::path& allowlist, std::set<std::string> roles)
    : socket_(std::make_unique<zmq::socket_t>(context, zmq::socket_type::rep)),
      allowlist_(allowlist),
      roles_(std::move(roles)) {
  socket_->set(zmq::sockopt::linger, 0);
  socket_->bind(kZapEndpoint);
}
ZapHandler::~ZapHandler() = default;

void* ZapHandler::socket() {
  return socket_->handle();
}

void ZapHandler::answer(SparingLog& log) {
  std::vector<zmq::message_t> request;  // version, request id, domain, address, identity, mechanism, key
  while (receive_parts(*socket_, 7, request)) {
    std::string why = "malformed authentication request", key;
    if (request.size() == 7 && request[6].size() == 32) {
      std::array<char, 41> z85{};
      zmq_z85_encode(z85.data(), request[6].data<std::uint8_t>(), 32);
      key = z85.data();
      why = refusal(key);
      if (!why.empty()) why += " (from " + request[3].to_string() + ")";
    }
    if (!why.empty()) {
      ++refused_;
      last_refusal_ = why;
      log.tell(key, "refused: " + why);
    }
    const std::string id = request.size() > 1 ? request[1].to_string() : std::string();
    const std::string parts[] = {"1.0", id, why.empty() ? "200" : "400", why.empty() ? "OK" : "key not allowed",
                                 key,   ""};
    for (std::size_t i = 0; i < std::size(parts); ++i)
      socket_->send(zmq::buffer(parts[i]), i + 1 < std::size(parts) ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }
}

std::string ZapHandler::refusal(const std::string& public_key) {
  const std::optional<AllowedPeer> peer = allowlist_.find(public_key);
  if (!peer)
    return "key " + public_key + " is not in the allowlist" +
           (allowlist_.error().empty() ? "" : ": " + allowlist_.error());
  if (!roles_.contains(peer->role))
    return "key " + public_key + " (" + peer->name + ") has role " + peer->role + ", which may not connect here";
  return {};
}

SocketEvents::SocketEvents(zmq::context_t& context, zmq::socket_t& watched, const std::string& name)
    : watched_(watched), socket_(std::make_unique<zmq::socket_t>(context, zmq::socket_type::pair)) {
  const std::string address = "inproc://events-" + name;
  constexpr int kEvents = ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                          ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                          ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
  if (zmq_socket_monitor(watched.handle(), address.c_str(), kEvents) != 0) throw zmq::error_t();
  socket_->set(zmq::sockopt::linger, 0);
  socket_->connect(address);
}

SocketEvents::~SocketEvents() {
  zmq_socket_monitor(watched_.handle(), nullptr, 0);
}

void* SocketEvents::socket() {
  return socket_->handle();
}

std::vector<SocketEvents::Kind> SocketEvents::drain() {
  std::vector<Kind> kinds;
  std::vector<zmq::message_t> parts;
  while (receive_parts(*socket_, 2, parts)) {
    if (parts[0].size() < sizeof(std::uint16_t)) continue;
    std::uint16_t event;
    std::memcpy(&event, parts[0].data(), sizeof event);
    std::uint32_t value = 0;
    if (parts[0].size() >= sizeof event + sizeof value)
      std::memcpy(&value, parts[0].data<std::uint8_t>() + sizeof event, sizeof value);
    if (event == ZMQ_EVENT_ACCEPTED) kinds.push_back(Kind::kAccepted);
    if (event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) kinds.push_back(Kind::kConnected);
    if (event == ZMQ_EVENT_DISCONNECTED) kinds.push_back(Kind::kDisconnected);
    if (event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) kinds.push_back(Kind::kKeyRefused);
    if (event == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL)
      kinds.push_back(is_about_keys(value) ? Kind::kHandshakeFailed : Kind::kHandshakeBroken);
    if (event == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL) kinds.push_back(Kind::kHandshakeBroken);
  }
  return kinds;
}

void block_signals() {
  sigset_t signals;
  sigfillset(&signals);
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigdelset(&signals, fault);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

void set_common_options(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::sndbuf, 256 * 1024);
  socket.set(zmq::sockopt::rcvbuf, 256 * 1024);
  socket.set(zmq::sockopt::handshake_ivl, 2000);
  socket.set(zmq::sockopt::rcvhwm, 0);
  socket.set(zmq::sockopt::heartbeat_ivl, 0);
  socket.set(zmq::sockopt::tcp_keepalive, 1);  // a cut cable is noticed within two seconds or so
  socket.set(zmq::sockopt::tcp_keepalive_idle, 1);
  socket.set(zmq::sockopt::tcp_keepalive_intvl, 1);
  socket.set(zmq::sockopt::tcp_keepalive_cnt, 2);
  socket.set(zmq::sockopt::tcp_maxrt, 2000);
  socket.set(zmq::sockopt::reconnect_ivl, 100);
  socket.set(zmq::sockopt::reconnect_ivl_max, 500);  // a link that comes back is in use within a second
}

void set_curve_server(zmq::socket_t& socket, const CurveKeys& keys) {
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_secretkey, keys.secret_key);
}

void set_curve_client(zmq::socket_t& socket, const CurveKeys& keys, const std::string& server_public_key) {
  if (!is_z85_key(server_public_key)) throw ConfigError("keys need the sender's public key too (40 characters of Z85)");
  socket.set(zmq::sockopt::curve_serverkey, server_public_key);
  socket.set(zmq::sockopt::curve_publickey, keys.public_key);
  socket.set(zmq::sockopt::curve_secretkey, keys.secret_key);
}

std::string bind_endpoint(zmq::socket_t& socket, const std::string& endpoint) {
  socket.set(zmq::sockopt::ipv6, endpoint.find('[') != std::string::npos);
  try {
    socket.bind(resolved_endpoint(endpoint));
  } catch (const zmq::error_t& error) {
    throw DeviceError("cannot listen on " + endpoint + ": " + error.what() +
                      (error.num() == EADDRINUSE ? "; another program uses this port, choose another one" : ""));
  }
  return socket.get(zmq::sockopt::last_endpoint);
}

void connect_endpoint(zmq::socket_t& socket, const std::string& endpoint) {
  socket.set(zmq::sockopt::ipv6, endpoint.find('[') != std::string::npos);
  if (endpoint.ends_with(":*") || endpoint.ends_with(":0"))
    throw ConfigError("endpoint " + endpoint + ": to connect, name the port that the other side listens on");
  try {
    socket.connect(resolved_endpoint(endpoint));
  } catch (const zmq::error_t& error) {
    throw ConfigError("endpoint " + endpoint + ": " + error.what() + "; write it as tcp://HOST:PORT");
  }
}

std::string public_key_of(const zmq::message_t& message) {
  const char* const key = zmq_msg_gets(const_cast<zmq_msg_t*>(message.handle()), "User-Id");
  return key ? key : "";
}

bool receive_parts(zmq::socket_t& socket, std::size_t max_parts, std::vector<zmq::message_t>& parts) {
  parts.clear();
  zmq::message_t part;
  if (!socket.recv(part, zmq::recv_flags::dontwait)) return false;
  bool more = part.more();
  parts.push_back(std::move(part));
  while (more) {  // the rest of a message is there once its first part is
    zmq::message_t next;
    if (!socket.recv(next)) return false;
    more = next.more();
    if (parts.size() < max_parts + 1) parts.push_back(std::move(next));
  }
  return true;
}

std::string reason_of(const std::string& error) {
  return error.substr(0, error.find_first_of(": "));
}

}  // namespace sheen
