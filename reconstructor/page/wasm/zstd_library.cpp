// SPDX-License-Identifier: Apache-2.0
// What files are unpacked with, under the names of zstd's library.
#include <zstd.h>

#include "reconstructor/page/wasm/zstd_frame.h"

namespace {

std::span<const std::uint8_t> bytes_of(const void* data, std::size_t size) {
  return {static_cast<const std::uint8_t*>(data), size};
}

}  // namespace

extern "C" unsigned long long ZSTD_getFrameContentSize(const void* data, std::size_t size) {
  return sheen::zstd_content_size(bytes_of(data, size)).value_or(ZSTD_CONTENTSIZE_UNKNOWN);
}

extern "C" std::size_t ZSTD_decompress(void* out, std::size_t room, const void* data, std::size_t size) {
  const bool whole = sheen::unpack_zstd(bytes_of(data, size), {static_cast<std::uint8_t*>(out), room});
  return whole ? room : static_cast<std::size_t>(-1);
}
