// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace sheen {

/// CRC-32C (Castagnoli polynomial 0x1EDC6F41, reflected, inverted at both ends; RFC 3720), by the processor's own
/// instruction where there is one. Pass an earlier result as `crc` to go on where it ended.
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

/// The same by table, on any processor.
std::uint32_t crc32c_portable(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

}  // namespace sheen
