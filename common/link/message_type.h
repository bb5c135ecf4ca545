// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sheen {

inline constexpr std::uint16_t kWireMajor = 1;  ///< peers of another major version are refused

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

}  // namespace sheen
