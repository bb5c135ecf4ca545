// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/image/image_codec.h"

namespace sheen {

inline constexpr std::uint16_t kWireMajor = 1;                        ///< peers of another major version are refused
inline constexpr std::size_t kMaxHeaderBytes = std::size_t(1) << 20;  ///< of a capture's Protobuf header

enum class MessageType : std::uint16_t {
  kHello = 1,    ///< receiver -> sender: protocol version, role, what it already holds
  kWelcome = 2,  ///< sender -> receiver: source session, version
  kCredit = 3,   ///< receiver -> sender: may send so many more captures
  kKeep = 4,     ///< sender -> receiver: a capture that is delivered at least once
  kLive = 5,     ///< sender -> receiver: the newest frame, for looking at; may be dropped
  kAck = 6,      ///< receiver -> sender: durable up to this sequence of this source session
  kRefuse = 7,   ///< either way: why the other side's message was not accepted
  kStatus = 8,   ///< on the monitor socket
  kEnd = 9,      ///< sender -> receiver: the source has ended after so many captures
};

/// A capture as it travels and as the journal keeps it: 8-byte envelope (magic, major, type), Protobuf header, raw blob
/// (pixels, then mask). Pixels stay outside Protobuf.
struct EncodedCapture {
  std::vector<std::uint8_t> envelope;
  std::vector<std::uint8_t> header;
  std::vector<std::uint8_t> blob;
};

EncodedCapture encode_capture(const Capture& capture, MessageType type, Codec codec);

/// What a list of captures shows.
struct CaptureLabel {
  std::string source_session, name;
  std::uint64_t sequence = 0;
};
/// Of a capture whose pixels are not at hand. Throws ProtocolError.
CaptureLabel decode_label(std::span<const std::uint8_t> envelope, std::span<const std::uint8_t> header);

/// Believes nothing: every size, enum, number, rotation and the CRC-32C are checked. Throws ProtocolError that names
/// the field; never reads outside the spans.
Capture decode_capture(std::span<const std::uint8_t> envelope, std::span<const std::uint8_t> header,
                       std::span<const std::uint8_t> blob);

}  // namespace sheen
