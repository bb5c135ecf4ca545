// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/capture/rig_motion.h"
#include "common/link/message_type.h"
#include "common/link/status.h"

namespace sheen {

/// The 8 bytes in front of every message: "SHEN", then major version and type, little-endian. They stay as they are in
/// every version, so that peers of different versions can tell each other.
inline constexpr std::size_t kEnvelopeBytes = 8;
struct Envelope {
  std::uint16_t major = kWireMajor;
  MessageType type{};
};
std::array<std::uint8_t, kEnvelopeBytes> encode_envelope(MessageType type);
/// Throws ProtocolError when the size or the magic is wrong; version and type are for the caller to judge.
Envelope decode_envelope(std::span<const std::uint8_t> bytes);
/// Names both versions and what to do; empty when they agree. `peer` names the other side.
std::string version_error(const Envelope& envelope, const std::string& peer);

struct HeldCaptures {
  std::uint64_t durable = 0;   ///< every capture up to this sequence is on the receiver's disk
  std::uint64_t received = 0;  ///< every capture up to this sequence need not be sent again
};

struct Hello {
  std::string role;
  std::uint32_t credits = 0;
  std::map<std::string, HeldCaptures> held;  ///< by source session
  std::int64_t clock_ns = 0;
};
/// What became of the camera's frames on the tracker, since its start: most are never sent.
struct TrackerFrames {
  std::uint64_t judged = 0;
  std::map<std::string, std::uint64_t> refused;  ///< by reason; judged less these were kept
  std::string trouble;                           ///< for a person, while most frames are refused; else empty
};

struct Welcome {
  std::string source_session;
  std::uint64_t first_sequence = 1;  ///< the oldest capture that the sender can still send
  std::int64_t hello_clock_ns = 0;
  std::int64_t clock_ns = 0;
  TrackerFrames frames;
  RigMotion motion;  ///< of all its captures, as far as it knows
};
struct Credit {
  std::uint32_t captures = 0;
  std::int64_t clock_ns = 0;  ///< when a welcome is wanted that gives it back; else 0
};
struct Ack {
  std::string source_session;
  std::uint64_t durable = 0;
  bool end_seen = false;
};
inline constexpr std::size_t kMaxTextBytes = 1024;  ///< of a reason, a failure or a status line
/// As much of a text as a message may carry, without what it may not.
std::string sayable(std::string text);
struct Refuse {
  std::string reason;
};
struct End {
  std::string source_session;
  std::uint64_t last_sequence = 0;
  std::string failure;  ///< why the source ended before its time; empty when it came to its end
};

using Bytes = std::vector<std::uint8_t>;
Bytes encode(const Hello& message);
Bytes encode(const Welcome& message);
Bytes encode(const Credit& message);
Bytes encode(const Ack& message);
Bytes encode(const Refuse& message);
Bytes encode(const End& message);

// Each throws ProtocolError that names the field.
Hello decode_hello(std::span<const std::uint8_t> bytes);
Welcome decode_welcome(std::span<const std::uint8_t> bytes);
Credit decode_credit(std::span<const std::uint8_t> bytes);
Ack decode_ack(std::span<const std::uint8_t> bytes);
Refuse decode_refuse(std::span<const std::uint8_t> bytes);
End decode_end(std::span<const std::uint8_t> bytes);

/// A status message whole: envelope and body in one part.
Bytes encode_status(const Status& status);
Status decode_status(std::span<const std::uint8_t> message);

}  // namespace sheen
