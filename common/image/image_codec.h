// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "common/image/raw_image.h"

namespace sheen {

enum class Codec : std::uint8_t {
  kUnspecified = 0,
  kRaw = 1,
  kDeltaZstd = 2,  ///< difference to the left neighbour of the same colour site, then zstd: lossless
};

/// Packs image after image in the same buffers, which are as large as the largest of them.
class PixelPacker {
 public:
  PixelPacker();
  ~PixelPacker();

  /// The pixels (every byte of every row, padding included), then the mask row by row, as `codec` packs them. Lossless.
  std::vector<std::uint8_t> pack(const RawImage& image, const ImageU8& mask, Codec codec);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

/// Unpacks nothing. Throws ProtocolError unless the blob says of itself that it holds exactly so many bytes.
void require_unpacked_size(std::span<const std::uint8_t> blob, Codec codec, std::size_t bytes);

/// Inverse of `PixelPacker::pack`: fills `image.bytes` and `mask`, whose formats and sizes are already set and sane.
/// Throws ProtocolError when the blob does not hold exactly that much.
void unpack_pixels(std::span<const std::uint8_t> blob, Codec codec, RawImage& image, ImageU8& mask);

}  // namespace sheen
