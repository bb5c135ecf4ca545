// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/image/image_codec.h"
#include "common/link/message_type.h"

namespace sheen {

inline constexpr std::size_t kMaxHeaderBytes = std::size_t(1) << 20;  ///< of a capture's Protobuf header

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
