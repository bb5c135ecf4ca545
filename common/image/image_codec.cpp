// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_codec.h"

#define ZSTD_STATIC_LINKING_ONLY  // ZSTD_c_literalCompressionMode
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>

#include "common/base/errors.h"

namespace sheen {
namespace {

// Differences of pixels seldom repeat. The level hardly looks for what does, which takes three fifths of the time of
// level 1; entropy coding, which such levels leave out, is what makes the differences small. One in a hundred bytes
// more.
constexpr int kZstdLevel = -20;

/// Rows of `stride` bytes, of which the first `row_bytes` are pixels whose left neighbour of the same colour site lies
/// `step` bytes before.
struct Layout {
  std::size_t stride = 0, row_bytes = 0, step = 1, rows = 0;
  std::size_t size() const { return stride * rows; }
};

Layout layout_of(const RawImage& image) {
  const std::size_t pixel = bytes_per_pixel(image.format);
  const bool bayer = pixel == 1 && image.format != PixelFormat::kMono8;
  return {image.stride, image.width * pixel, bayer ? 2 : pixel, static_cast<std::size_t>(image.height)};
}

Layout layout_of(const ImageU8& mask) {
  const auto width = static_cast<std::size_t>(mask.width());
  return {width, width, 1, static_cast<std::size_t>(mask.height())};
}

void subtract_left_neighbours(const std::uint8_t* in, const Layout& layout, std::uint8_t* out) {
  for (std::size_t y = 0; y < layout.rows; ++y, in += layout.stride, out += layout.stride) {
    const std::size_t first = std::min(layout.step, layout.row_bytes);
    std::memcpy(out, in, first);
    for (std::size_t i = first; i < layout.row_bytes; ++i)
      out[i] = static_cast<std::uint8_t>(in[i] - in[i - layout.step]);
    std::memcpy(out + layout.row_bytes, in + layout.row_bytes, layout.stride - layout.row_bytes);
  }
}

void add_left_neighbours(std::uint8_t* bytes, const Layout& layout) {
  for (std::size_t y = 0; y < layout.rows; ++y, bytes += layout.stride)
    for (std::size_t i = layout.step; i < layout.row_bytes; ++i)
      bytes[i] = static_cast<std::uint8_t>(bytes[i] + bytes[i - layout.step]);
}

[[noreturn]] void wrong_size(std::size_t holds, std::size_t needed) {
  throw ProtocolError("blob: holds " + std::to_string(holds) + " bytes where image and mask need " +
                      std::to_string(needed));
}

}  // namespace

struct PixelPacker::Buffers {
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };
  std::unique_ptr<ZSTD_CCtx, Free> context{ZSTD_createCCtx()};
  std::vector<std::uint8_t> plain, packed;
};

PixelPacker::PixelPacker() : buffers_(std::make_unique<Buffers>()) {
  ZSTD_CCtx_setParameter(buffers_->context.get(), ZSTD_c_compressionLevel, kZstdLevel);
  ZSTD_CCtx_setParameter(buffers_->context.get(), ZSTD_c_literalCompressionMode, ZSTD_ps_enable);
}

PixelPacker::~PixelPacker() = default;

std::vector<std::uint8_t> PixelPacker::pack(const RawImage& image, const ImageU8& mask, Codec codec) {
  const std::size_t bytes = image.bytes.size() + mask.size();
  if (codec == Codec::kRaw) {
    std::vector<std::uint8_t> plain;
    plain.reserve(bytes);
    plain.insert(plain.end(), image.bytes.begin(), image.bytes.end());
    plain.insert(plain.end(), mask.data(), mask.data() + mask.size());
    return plain;
  }
  auto& [context, plain, packed] = *buffers_;
  plain.resize(bytes);
  subtract_left_neighbours(image.bytes.data(), layout_of(image), plain.data());
  subtract_left_neighbours(mask.data(), layout_of(mask), plain.data() + image.bytes.size());
  packed.resize(ZSTD_compressBound(bytes));
  const std::size_t size = ZSTD_compress2(context.get(), packed.data(), packed.size(), plain.data(), bytes);
  if (ZSTD_isError(size)) throw Error(std::string("zstd: ") + ZSTD_getErrorName(size));
  return {packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size)};
}

void require_unpacked_size(std::span<const std::uint8_t> blob, Codec codec, std::size_t bytes) {
  unsigned long long stated = blob.size();
  if (codec != Codec::kRaw) stated = ZSTD_getFrameContentSize(blob.data(), blob.size());
  if (stated == ZSTD_CONTENTSIZE_ERROR || stated == ZSTD_CONTENTSIZE_UNKNOWN)
    throw ProtocolError("blob: not a zstd frame of stated size");
  if (stated != bytes) wrong_size(stated, bytes);
}

void unpack_pixels(std::span<const std::uint8_t> blob, Codec codec, RawImage& image, ImageU8& mask) {
  const Layout pixels = layout_of(image), mask_layout = layout_of(mask);
  const std::size_t needed = pixels.size() + mask.size();
  require_unpacked_size(blob, codec, needed);
  if (codec == Codec::kRaw) {
    image.bytes.assign(blob.begin(), blob.begin() + static_cast<std::ptrdiff_t>(pixels.size()));
    std::copy(blob.begin() + static_cast<std::ptrdiff_t>(pixels.size()), blob.end(), mask.data());
    return;
  }
  image.bytes.resize(needed);
  const std::size_t size = ZSTD_decompress(image.bytes.data(), needed, blob.data(), blob.size());
  if (ZSTD_isError(size)) throw ProtocolError(std::string("blob: zstd says ") + ZSTD_getErrorName(size));
  if (size != needed) wrong_size(size, needed);
  std::copy(image.bytes.begin() + static_cast<std::ptrdiff_t>(pixels.size()), image.bytes.end(), mask.data());
  image.bytes.resize(pixels.size());
  add_left_neighbours(image.bytes.data(), pixels);
  add_left_neighbours(mask.data(), mask_layout);
}

}  // namespace sheen
