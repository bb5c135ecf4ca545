// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/link/clock_comparison.h"
#include "common/link/wire.h"
#include "common/link/wire_messages.h"

namespace sheen {

/// CURVE key pair of one role. Without keys only loopback endpoints are allowed.
struct CurveKeys {
  std::string public_key;  ///< Z85
  std::string secret_key;  ///< Z85
};
/// Writes NAME.pub and NAME.key (mode 0600), refusing to overwrite. Throws FileError.
CurveKeys generate_keys(const std::filesystem::path& folder, const std::string& name);
CurveKeys load_keys(const std::filesystem::path& key_file);          ///< the .key file; throws FileError
std::string load_public_key(const std::filesystem::path& pub_file);  ///< throws FileError

struct SenderOptions {
  std::string endpoint = "tcp://127.0.0.1:7410";  ///< bound
  std::optional<CurveKeys> keys;
  std::filesystem::path allowlist;  ///< file of public keys, a line each ("KEY role name"); reloaded when it changes
  std::size_t retained = 64;        ///< keyframes kept until acknowledged; beyond it `keep` waits
  Codec codec = Codec::kRaw;
  std::string source_session;
  /// Captures that an earlier run may have sent under the same session, and a receiver may so hold before this run has
  /// sent any: those of a data set that is streamed again. 0 for a source that never comes again.
  std::uint64_t sent_before = 0;
  RigMotion motion;  ///< told to every receiver
};

struct SenderStats {
  std::uint64_t kept = 0, delivered = 0, acknowledged = 0, resent = 0;
  std::uint64_t live_sent = 0, live_dropped = 0;
  std::uint64_t rejected_messages = 0;  ///< malformed or of another version
  std::uint64_t refused_keys = 0;       ///< handshakes of unknown, revoked or missing keys
  std::uint64_t broken_handshakes = 0;  ///< connections that ended before their handshake
  std::uint64_t hung_up = 0;            ///< times that all connections were closed, for a flood or too many of them
  std::string last_refusal;             ///< who was refused, and why; keys, second receivers, malformed messages
  bool peer_connected = false;
};

/// The tracker's end of the data link: binds a ROUTER, sends while it has credits. Thread-safe; its own I/O thread.
class CaptureSender {
 public:
  /// Throws DeviceError when the address cannot be bound, ConfigError for a non-loopback one without keys, for keys
  /// without an allowlist and for a broken allowlist.
  explicit CaptureSender(const SenderOptions& options);
  ~CaptureSender();

  /// Delivered at least once, in order. Waits while `retained` captures are unacknowledged; false when it timed out
  /// (the capture is then not taken). An empty source_session and a sequence of 0 are filled in; else the session must
  /// be the sender's and the sequence the one after the last. Throws ProtocolError for an invalid capture.
  bool keep(Capture capture, std::chrono::milliseconds timeout);
  /// Latest wins; never waits for the network. Throws ProtocolError for an invalid capture.
  void live(Capture capture);
  /// Tells the receiver that nothing more comes, and waits until it has acknowledged that and all kept captures.
  /// `failure` says why the source ended before its time; empty when it came to its end.
  bool finish(std::chrono::milliseconds timeout, const std::string& failure = {});
  /// What the next welcome tells of the frames that the tracker has judged.
  void report(const TrackerFrames& frames);
  /// The address in use, with the port that the system chose if `options.endpoint` left it open (":*").
  std::string endpoint() const;
  SenderStats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct ReceiverOptions {
  std::string endpoint = "tcp://127.0.0.1:7410";  ///< connected to
  std::optional<CurveKeys> keys;
  std::string server_public_key;  ///< of the sender, with `keys`
  int credits = 2;
  /// What is already durable: source session -> highest acknowledged sequence.
  std::map<std::string, std::uint64_t> held;
  /// Called whenever `next` has something more to give, by the receiver's thread: must be quick and not call it.
  std::function<void()> on_arrival = {};
};

struct Received {
  Capture capture;
  bool live = false;
};

struct ReceiverStats {
  std::uint64_t kept = 0, live = 0, duplicates = 0, rejected_messages = 0, bytes = 0;
  std::uint64_t missing = 0;  ///< kept captures that the sender no longer has because another receiver took them
  std::map<std::string, std::uint64_t> rejected_by_reason;
  TrackerFrames tracker;             ///< the sender's frames, as it told about a second ago
  RigMotion motion;                  ///< of the sender's captures, as it says; unspecified before it came
  std::optional<ClockOffset> clock;  ///< the sender's steady clock against this one; measured again every second
  bool connected = false;
  bool came = false;   ///< a sender has been connected since the start
  bool ended = false;  ///< the sender said that its source has ended, and `next` has returned everything it kept
  std::string source_failure;  ///< why the source ended before its time, as the sender said; else empty
  std::string last_error;
};

/// The reconstructor's end: a DEALER that connects, says hello (again after every reconnect), and gives credits.
class CaptureReceiver {
 public:
  explicit CaptureReceiver(const ReceiverOptions& options);  ///< throws ConfigError
  ~CaptureReceiver();

  /// The next capture, validated and deduplicated; nothing after `timeout`. A credit is returned to the sender when the
  /// capture is taken from here: no more than twice `credits` wait, whatever the sender sends.
  std::optional<Received> next(std::chrono::milliseconds timeout);
  /// Call once the capture is durable.
  void acknowledge(const std::string& source_session, std::uint64_t sequence);
  /// Takes no more kept captures of a source session, and tells the sender why; it keeps what is not acknowledged.
  void refuse(const std::string& source_session, const std::string& reason);
  ReceiverStats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
