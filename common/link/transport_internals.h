// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/sparing_log.h"
#include "common/link/transport.h"

namespace zmq {
class context_t;
class message_t;
class socket_t;
}  // namespace zmq

// Shared by the ends of the data link and of the monitor socket; nobody else includes it.
namespace sheen {

/// Throws ConfigError when an endpoint is malformed, or other machines can reach it and it has no keys.
void require_keys_beyond_loopback(const std::string& endpoint, bool has_keys);
bool is_z85_key(const std::string& text);

struct AllowedPeer {
  std::string role;
  std::string name;
};

/// The file of public keys that may connect; a line each: "KEY role name", '#' begins a comment.
class Allowlist {
 public:
  explicit Allowlist(std::filesystem::path path);  ///< throws ConfigError naming file and line
  /// Reads the file again if it has changed. A file that is gone or broken by then allows nobody.
  std::optional<AllowedPeer> find(const std::string& public_key);
  const std::string& error() const { return error_; }  ///< why nobody is allowed at present

 private:
  void load();
  std::filesystem::path path_;
  std::string stamp_;
  std::map<std::string, AllowedPeer> peers_;
  std::string error_;
};

/// Wakes a thread that polls on sockets.
class Wakeup {
 public:
  Wakeup();
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;
  int fd() const { return fd_; }
  void notify();
  void drain();

 private:
  int fd_;
};

/// Answers the authentication requests (ZeroMQ RFC 27) of all CURVE servers in one context. Must exist before they
/// bind.
class ZapHandler {
 public:
  ZapHandler(zmq::context_t& context, const std::filesystem::path& allowlist, std::set<std::string> roles);
  ~ZapHandler();
  void* socket();
  void answer(SparingLog& log);  ///< all requests that wait; never blocks
  /// Empty when the key may still be connected, else why not.
  std::string refusal(const std::string& public_key);
  std::uint64_t refused() const { return refused_; }
  const std::string& last_refusal() const { return last_refusal_; }

 private:
  std::unique_ptr<zmq::socket_t> socket_;
  Allowlist allowlist_;
  std::set<std::string> roles_;
  std::uint64_t refused_ = 0;
  std::string last_refusal_;
};

/// What happens to a socket's connections. Must be drained whenever it is readable: unread events stop the socket.
class SocketEvents {
 public:
  /// `kHandshakeFailed`: the two sides' keys do not fit, or only one has any. `kHandshakeBroken`: the other side went
  /// away before it, or said nothing for too long.
  enum class Kind { kAccepted, kConnected, kDisconnected, kKeyRefused, kHandshakeFailed, kHandshakeBroken };
  SocketEvents(zmq::context_t& context, zmq::socket_t& watched, const std::string& name);
  ~SocketEvents();
  void* socket();
  std::vector<Kind> drain();

 private:
  zmq::socket_t& watched_;
  std::unique_ptr<zmq::socket_t> socket_;
};

/// Leaves signals to the other threads: here they would only interrupt system calls.
void block_signals();

/// The same on every socket that leaves the process, but for a watcher's limit on what waits. Chosen so that no peer
/// can end the process (docs/decisions/hostile_peers.md): libzmq 4.3.4 aborts where a connection whose input it has
/// stopped breaks, so it must never stop one for a full queue, nor send heartbeats on one. Whoever has the socket
/// therefore takes at once what comes, and hangs up on a flood.
void set_common_options(zmq::socket_t& socket);

/// Messages in one go, without a pause, after which a peer floods: many times what honest ones have on their way, and
/// what a busy reader of small messages still keeps up with.
inline constexpr int kFlood = 100'000;
/// Of a peer that says something every second: without a word for so long it has left, or is frozen.
inline constexpr std::chrono::milliseconds kSilence{5000};
/// After a fault in a thread's round, before the next.
inline constexpr std::chrono::milliseconds kFaultPause{100};
void set_curve_server(zmq::socket_t& socket, const CurveKeys& keys);
void set_curve_client(zmq::socket_t& socket, const CurveKeys& keys, const std::string& server_public_key);

/// Binds; returns the address with its port. Throws DeviceError.
std::string bind_endpoint(zmq::socket_t& socket, const std::string& endpoint);
void connect_endpoint(zmq::socket_t& socket, const std::string& endpoint);  ///< throws ConfigError

/// Of who sent it; empty without CURVE.
std::string public_key_of(const zmq::message_t& message);

/// Takes one whole message; false when none waits. Of a message of more than `max_parts` one more part is kept to tell.
bool receive_parts(zmq::socket_t& socket, std::size_t max_parts, std::vector<zmq::message_t>& parts);

/// The first word of an error: what it is counted under.
std::string reason_of(const std::string& error);

}  // namespace sheen
