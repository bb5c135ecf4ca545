// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sheen {

// The decompressor of zstd for where its library is not: a browser. Frames as RFC 8878 has them, without dictionaries;
// the checksum at the end is not looked at, for what we read has one of its own.

/// The size that a frame claims to have unpacked; empty where it is none, or does not say.
std::optional<std::uint64_t> zstd_content_size(std::span<const std::uint8_t> frame);

/// Unpacks a frame into room of exactly its size; true if it is whole and fits.
bool unpack_zstd(std::span<const std::uint8_t> frame, std::span<std::uint8_t> out);

}  // namespace sheen
