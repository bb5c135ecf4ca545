// SPDX-License-Identifier: Apache-2.0
#include "common/link/wire_messages.h"

#include <algorithm>
#include <limits>

#include "common/base/errors.h"
#include "common/capture/capture_validation.h"
#include "common/link/proto_io.h"
#include "proto/link.pb.h"
#include "proto/status.pb.h"

namespace sheen {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic{'S', 'H', 'E', 'N'};
constexpr std::size_t kMaxMessageBytes = std::size_t(1) << 20;
constexpr std::uint32_t kMaxCredits = 1024;
constexpr std::uint64_t kMaxSequence = std::numeric_limits<std::int64_t>::max();
constexpr int kMaxSessions = 16384, kMaxGauges = 1024, kMaxReasons = 64;
constexpr std::size_t kMaxIdBytes = 128;

const std::string& checked(const std::string& text, std::size_t max_bytes, const char* field) {
  if (text.size() > max_bytes || !is_plain_text(text))
    throw ProtocolError(std::string(field) + ": must be UTF-8 without control characters, at most " +
                        std::to_string(max_bytes) + " bytes");
  return text;
}

std::uint32_t checked_credits(std::uint32_t value, const char* field) {
  if (value > kMaxCredits)
    throw ProtocolError(std::string(field) + ": " + std::to_string(value) + " is more than " +
                        std::to_string(kMaxCredits));
  return value;
}

/// Sequences are counted up from 1, one per capture: what would wrap has never been reached.
std::uint64_t checked_sequence(std::uint64_t value, const char* field) {
  if (value > kMaxSequence)
    throw ProtocolError(std::string(field) + ": " + std::to_string(value) +
                        " is larger than any sequence that can be reached");
  return value;
}

TrackerFrames checked_frames(const v1::TrackerFrames& in) {
  TrackerFrames frames{.judged = in.judged(),
                       .trouble = checked(in.trouble(), kMaxTextBytes, "welcome.frames.trouble")};
  if (in.refused_size() > kMaxReasons) throw ProtocolError("welcome.frames.refused: too many reasons");
  std::uint64_t refused = 0;
  for (const v1::Refused& entry : in.refused()) {
    frames.refused[checked(entry.reason(), kMaxIdBytes, "welcome.frames.refused.reason")] = entry.frames();
    if (entry.frames() > frames.judged - refused) throw ProtocolError("welcome.frames.refused: more than were judged");
    refused += entry.frames();
  }
  return frames;
}

Motion checked_motion(int value, const char* field) {
  if (value < 0 || value > static_cast<int>(Motion::kMoves))
    throw ProtocolError(std::string(field) + ": unknown value " + std::to_string(value));
  return static_cast<Motion>(value);
}

RigMotion checked_motion(const v1::RigMotion& in) {
  return {.camera = checked_motion(in.camera(), "welcome.motion.camera"),
          .light = checked_motion(in.light(), "welcome.motion.light")};
}

}  // namespace

std::string sayable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.substr(0, kMaxTextBytes);
}

std::array<std::uint8_t, kEnvelopeBytes> encode_envelope(MessageType type) {
  const auto t = static_cast<std::uint16_t>(type);
  return {kMagic[0],
          kMagic[1],
          kMagic[2],
          kMagic[3],
          static_cast<std::uint8_t>(kWireMajor & 0xFF),
          static_cast<std::uint8_t>(kWireMajor >> 8),
          static_cast<std::uint8_t>(t & 0xFF),
          static_cast<std::uint8_t>(t >> 8)};
}

Envelope decode_envelope(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kEnvelopeBytes)
    throw ProtocolError("envelope: has " + std::to_string(bytes.size()) + " bytes, must have 8");
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin()))
    throw ProtocolError("envelope.magic: not a Sheen message");
  Envelope envelope;
  envelope.major = static_cast<std::uint16_t>(bytes[4] | bytes[5] << 8);
  envelope.type = static_cast<MessageType>(bytes[6] | bytes[7] << 8);
  return envelope;
}

std::string version_error(const Envelope& envelope, const std::string& peer) {
  if (envelope.major == kWireMajor) return {};
  return "envelope.major: " + peer + " speaks protocol version " + std::to_string(envelope.major) +
         ", this side version " + std::to_string(kWireMajor) + "; install the same release on both";
}

Bytes encode(const Hello& message) {
  v1::Hello out;
  out.set_role(message.role);
  out.set_credits(message.credits);
  out.set_clock_ns(message.clock_ns);
  for (const auto& [session, held] : message.held) {
    v1::Held& entry = *out.add_held();
    entry.set_source_session(session);
    entry.set_durable(held.durable);
    entry.set_received(held.received);
  }
  return serialize(out);
}

Hello decode_hello(std::span<const std::uint8_t> bytes) {
  const auto in = parse<v1::Hello>(bytes, kMaxMessageBytes, "hello");
  Hello hello{.role = checked(in.role(), kMaxIdBytes, "hello.role"),
              .credits = checked_credits(in.credits(), "hello.credits"),
              .clock_ns = in.clock_ns()};
  if (in.held_size() > kMaxSessions) throw ProtocolError("hello.held: too many source sessions");
  for (const v1::Held& held : in.held())
    hello.held[checked(held.source_session(), kMaxIdBytes, "hello.held.source_session")] = {
        checked_sequence(held.durable(), "hello.held.durable"),
        checked_sequence(held.received(), "hello.held.received")};
  return hello;
}

Bytes encode(const Welcome& message) {
  v1::Welcome out;
  out.set_source_session(message.source_session);
  out.set_first_sequence(message.first_sequence);
  out.set_hello_clock_ns(message.hello_clock_ns);
  out.set_clock_ns(message.clock_ns);
  if (message.frames.judged > 0) {
    v1::TrackerFrames& frames = *out.mutable_frames();
    frames.set_judged(message.frames.judged);
    frames.set_trouble(message.frames.trouble);
    for (const auto& [reason, count] : message.frames.refused) {
      v1::Refused& entry = *frames.add_refused();
      entry.set_reason(reason);
      entry.set_frames(count);
    }
  }
  if (message.motion != RigMotion{}) {
    out.mutable_motion()->set_camera(static_cast<v1::Motion>(message.motion.camera));
    out.mutable_motion()->set_light(static_cast<v1::Motion>(message.motion.light));
  }
  return serialize(out);
}

Welcome decode_welcome(std::span<const std::uint8_t> bytes) {
  const auto in = parse<v1::Welcome>(bytes, kMaxMessageBytes, "welcome");
  if (in.source_session().empty()) throw ProtocolError("welcome.source_session: missing");
  if (in.first_sequence() == 0) throw ProtocolError("welcome.first_sequence: must be at least 1");
  return {.source_session = checked(in.source_session(), kMaxIdBytes, "welcome.source_session"),
          .first_sequence = checked_sequence(in.first_sequence(), "welcome.first_sequence"),
          .hello_clock_ns = in.hello_clock_ns(),
          .clock_ns = in.clock_ns(),
          .frames = checked_frames(in.frames()),
          .motion = checked_motion(in.motion())};
}

Bytes encode(const Credit& message) {
  v1::Credit out;
  out.set_captures(message.captures);
  out.set_clock_ns(message.clock_ns);
  return serialize(out);
}

Credit decode_credit(std::span<const std::uint8_t> bytes) {
  const auto in = parse<v1::Credit>(bytes, kMaxMessageBytes, "credit");
  return {.captures = checked_credits(in.captures(), "credit.captures"), .clock_ns = in.clock_ns()};
}

Bytes encode(const Ack& message) {
  v1::Ack out;
  out.set_source_session(message.source_session);
  out.set_durable(message.durable);
  out.set_end_seen(message.end_seen);
  return serialize(out);
}

Ack decode_ack(std::span<const std::uint8_t> bytes) {
  const auto in = parse<v1::Ack>(bytes, kMaxMessageBytes, "ack");
  return {.source_session = checked(in.source_session(), kMaxIdBytes, "ack.source_session"),
          .durable = checked_sequence(in.durable(), "ack.durable"),
          .end_seen = in.end_seen()};
}

Bytes encode(const Refuse& message) {
  v1::Refuse out;
  out.set_reason(message.reason);
  return serialize(out);
}

Refuse decode_refuse(std::span<const std::uint8_t> bytes) {
  return {.reason =
              checked(parse<v1::Refuse>(bytes, kMaxMessageBytes, "refuse").reason(), kMaxTextBytes, "refuse.reason")};
}

Bytes encode(const End& message) {
  v1::End out;
  out.set_source_session(message.source_session);
  out.set_last_sequence(message.last_sequence);
  out.set_failure(message.failure);
  return serialize(out);
}

End decode_end(std::span<const std::uint8_t> bytes) {
  const auto in = parse<v1::End>(bytes, kMaxMessageBytes, "end");
  return {.source_session = checked(in.source_session(), kMaxIdBytes, "end.source_session"),
          .last_sequence = checked_sequence(in.last_sequence(), "end.last_sequence"),
          .failure = checked(in.failure(), kMaxTextBytes, "end.failure")};
}

Bytes encode_status(const Status& status) {
  v1::Status out;
  out.set_role(status.role);
  out.set_source_session(status.source_session);
  out.set_sequence(status.sequence);
  out.set_clock_ns(status.clock_ns);
  out.set_state(static_cast<v1::SourceState>(status.state));
  out.set_message(status.message);
  for (const auto& [name, value] : status.gauges) {
    v1::Gauge& gauge = *out.add_gauges();
    gauge.set_name(name);
    gauge.set_value(value);
  }
  out.set_preview_jpeg(status.preview_jpeg.data(), status.preview_jpeg.size());
  const auto envelope = encode_envelope(MessageType::kStatus);
  const Bytes body = serialize(out);
  Bytes bytes(envelope.begin(), envelope.end());
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

Status decode_status(std::span<const std::uint8_t> message) {
  const Envelope envelope = decode_envelope(message.first(std::min(message.size(), kEnvelopeBytes)));
  if (const std::string error = version_error(envelope, "the publisher"); !error.empty()) throw ProtocolError(error);
  if (envelope.type != MessageType::kStatus) throw ProtocolError("envelope.type: not a status message");
  const auto in = parse<v1::Status>(message.subspan(kEnvelopeBytes), kMaxMessageBytes, "status");
  if (in.state() < 0 || in.state() > static_cast<int>(SourceState::kEnded))
    throw ProtocolError("status.state: unknown value " + std::to_string(in.state()));
  if (in.gauges_size() > kMaxGauges) throw ProtocolError("status.gauges: too many");
  Status status{.role = checked(in.role(), kMaxIdBytes, "status.role"),
                .source_session = checked(in.source_session(), kMaxIdBytes, "status.source_session"),
                .sequence = in.sequence(),
                .clock_ns = in.clock_ns(),
                .state = static_cast<SourceState>(in.state()),
                .message = checked(in.message(), kMaxTextBytes, "status.message"),
                .preview_jpeg = {in.preview_jpeg().begin(), in.preview_jpeg().end()}};
  for (const v1::Gauge& gauge : in.gauges())
    status.gauges[checked(gauge.name(), kMaxIdBytes, "status.gauges.name")] = gauge.value();
  return status;
}

}  // namespace sheen
