// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <google/protobuf/message_lite.h>
#include <google/protobuf/stubs/logging.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/errors.h"

namespace sheen {

inline std::vector<std::uint8_t> serialize(const google::protobuf::MessageLite& message) {
  std::vector<std::uint8_t> bytes(message.ByteSizeLong());
  message.SerializeWithCachedSizesToArray(bytes.data());
  return bytes;
}

/// Throws ProtocolError that names `field`.
template <typename Message>
Message parse(std::span<const std::uint8_t> bytes, std::size_t max_bytes, const char* field) {
  // The library would print a line for every malformed text that a peer sends; our errors say it once, and counted.
  [[maybe_unused]] static const auto silenced = google::protobuf::SetLogHandler(nullptr);
  Message message;
  if (bytes.size() > max_bytes)
    throw ProtocolError(std::string(field) + ": " + std::to_string(bytes.size()) + " bytes are too many");
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    throw ProtocolError(std::string(field) + ": not a Protobuf message of type " + message.GetTypeName());
  return message;
}

}  // namespace sheen
