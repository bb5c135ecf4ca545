// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/link/status.h"
#include "common/link/transport.h"

namespace sheen {

inline constexpr std::size_t kMaxStatusBytes = 100'000;  ///< of a status message with its preview

struct PublisherOptions {
  std::string endpoint = "tcp://127.0.0.1:7411";  ///< bound
  std::optional<CurveKeys> keys;
  std::filesystem::path allowlist;  ///< as of SenderOptions; the roles "monitor" and "reconstructor" may watch
};

struct PublisherStats {
  std::uint64_t published = 0;         ///< handed to the network, whoever listens
  std::uint64_t replaced = 0;          ///< overtaken by a newer one before that
  std::uint64_t previews_dropped = 0;  ///< left out because the message would have been too large
  std::uint64_t refused_keys = 0;
  std::string last_refusal;
};

/// Tells whoever watches how a daemon is doing: latest wins, at most a few messages per subscriber are buffered, and a
/// slow or stopped one is never waited for. Thread-safe; its own I/O thread.
class MonitorPublisher {
 public:
  explicit MonitorPublisher(const PublisherOptions& options);  ///< throws as CaptureSender does
  ~MonitorPublisher();

  void publish(Status status);
  std::string endpoint() const;  ///< with the port that the system chose
  PublisherStats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct SubscriberOptions {
  std::string endpoint = "tcp://127.0.0.1:7411";  ///< connected to
  std::optional<CurveKeys> keys;
  std::string server_public_key;  ///< of the publisher, with `keys`
};

struct SubscriberStats {
  std::uint64_t received = 0, rejected = 0;
  std::string last_error;
};

/// Sees the newest status only. To be used from one thread.
class MonitorSubscriber {
 public:
  explicit MonitorSubscriber(const SubscriberOptions& options);  ///< throws ConfigError
  ~MonitorSubscriber();

  /// The newest status that has not been returned yet; nothing after `timeout`.
  std::optional<Status> next(std::chrono::milliseconds timeout);
  SubscriberStats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
