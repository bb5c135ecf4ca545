// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sheen {

/// How many frames a camera sent between two that arrived one after the other, by their ids. 16-bit ids (GigE Vision 1)
/// go on with 1 after 65535. A frame that an id of earlier overtakes is no gap.
constexpr std::uint64_t frames_between(std::uint64_t before, std::uint64_t now) {
  constexpr std::uint64_t kLastShortId = 65535;
  if (now > before) return now - before - 1;
  const bool wrapped = before <= kLastShortId && now > 0 && before - now > kLastShortId / 2;
  return wrapped ? kLastShortId - before + now - 1 : 0;
}

}  // namespace sheen
