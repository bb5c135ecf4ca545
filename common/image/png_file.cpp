// SPDX-License-Identifier: Apache-2.0
#include "common/image/png_file.h"

#include <png.h>

#include <algorithm>
#include <vector>

#include "common/base/errors.h"

namespace sheen {
namespace {

/// libpng's own structure with its clean-up.
struct PngImage {
  png_image info{};
  PngImage() { info.version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(&info); }
  [[noreturn]] void fail() const { throw Error(std::string("damaged PNG: ") + info.message); }

  bool has(png_uint_32 flag) const { return (info.format & flag) != 0; }
  int width() const { return static_cast<int>(info.width); }
  int height() const { return static_cast<int>(info.height); }
  /// All pixels in that format; `colours` gets the palette of a format that has one.
  template <typename Sample>
  std::vector<Sample> read(png_uint_32 format, void* colours = nullptr) {
    info.format = format;
    std::vector<Sample> pixels(PNG_IMAGE_SIZE(info) / sizeof(Sample));
    if (!png_image_finish_read(&info, nullptr, pixels.data(), 0, colours)) fail();
    return pixels;
  }
};

void begin(PngImage& png, std::string_view bytes) {
  if (!png_image_begin_read_from_memory(&png.info, bytes.data(), bytes.size())) png.fail();
  // Deflate packs at most 1032 : 1; a header that claims more must not be given the memory.
  const double claimed = double(png.info.width) * png.info.height * PNG_IMAGE_SAMPLE_CHANNELS(png.info.format);
  if (claimed / 8 > 1100.0 * double(bytes.size()))  // 1 bit per sample is the least
    throw Error("claims " + std::to_string(png.info.width) + " x " + std::to_string(png.info.height) +
                " pixels, more than the file can hold");
}

/// Of interleaved pixels, colours first.
Cutout cutout(const std::vector<std::uint8_t>& pixels, int width, int height, int colours, bool alpha) {
  Cutout out{ImageU8(width, height, colours), alpha ? ImageU8(width, height, 1) : ImageU8()};
  const int channels = colours + (alpha ? 1 : 0);
  for (std::size_t i = 0; i < std::size_t(width) * height; ++i) {
    std::copy_n(&pixels[i * channels], colours, out.colours.data() + i * colours);
    if (alpha) out.alpha.data()[i] = pixels[i * channels + colours];
  }
  return out;
}

Cutout read_cutout(PngImage& png) {
  const bool colour = png.has(PNG_FORMAT_FLAG_COLOR);
  // Read with alpha where there is one: libpng would else blend it with a background.
  const bool alpha = png.has(PNG_FORMAT_FLAG_ALPHA);
  const auto pixels = png.read<std::uint8_t>(colour ? (alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB)
                                                    : (alpha ? PNG_FORMAT_GA : PNG_FORMAT_GRAY));
  return cutout(pixels, png.width(), png.height(), colour ? 3 : 1, alpha);
}

/// A drawing in which 0 is background: the numbers of a palette's entries, or their colours where those say it.
Cutout read_palette_drawing(PngImage& png) {
  struct Entry {
    std::uint8_t r, g, b, a;
    bool black() const { return r == 0 && g == 0 && b == 0; }
  };
  std::vector<Entry> entries(256, Entry{});
  const std::size_t used = png.info.colormap_entries;
  const auto numbers = png.read<std::uint8_t>(PNG_FORMAT_RGBA_COLORMAP, entries.data());
  const bool by_number =
      entries[0].black() || std::none_of(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(used),
                                         [](const Entry& entry) { return entry.black(); });
  Cutout out{ImageU8(png.width(), png.height(), 1), ImageU8(png.width(), png.height(), 1)};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Entry& entry = entries[numbers[i]];
    out.colours.data()[i] = by_number ? numbers[i] : entry.black() ? 0 : 255;
    out.alpha.data()[i] = entry.a;
  }
  return out;
}

/// The same of 16 bits: 255 where a sample is not 0.
Cutout read_deep_drawing(PngImage& png) {
  const auto samples = png.read<std::uint16_t>(PNG_FORMAT_LINEAR_RGB_ALPHA);  // the colours are multiplied by alpha
  Cutout out{ImageU8(png.width(), png.height(), 1), ImageU8(png.width(), png.height(), 1)};
  for (std::size_t i = 0; i < out.alpha.size(); ++i) {
    const std::uint16_t* pixel = &samples[4 * i];
    out.colours.data()[i] = std::max({pixel[0], pixel[1], pixel[2]}) > 0 ? 255 : 0;
    out.alpha.data()[i] = static_cast<std::uint8_t>(pixel[3] >> 8);
  }
  return out;
}

}  // namespace

Cutout decode_png(std::string_view bytes) {
  PngImage png;
  begin(png, bytes);
  if (png.has(PNG_FORMAT_FLAG_LINEAR))
    throw Error("a PNG of 16 bits per channel cannot be read; write 8 bits, or EXR for more");
  return read_cutout(png);
}

ImageSize decode_png_size(std::string_view bytes) {
  PngImage png;
  begin(png, bytes);
  return {png.width(), png.height()};
}

ImageU8 decode_png_mask(std::string_view bytes) {
  PngImage png;
  begin(png, bytes);
  const Cutout drawing = png.has(PNG_FORMAT_FLAG_LINEAR)     ? read_deep_drawing(png)
                         : png.has(PNG_FORMAT_FLAG_COLORMAP) ? read_palette_drawing(png)
                                                             : read_cutout(png);
  return mask_of_drawing(drawing, /*lossy=*/false);
}

std::string encode_png(const ImageU8& image) {
  if (image.empty() || (image.channels() != 1 && image.channels() != 3 && image.channels() != 4))
    throw Error("a PNG needs pixels of 1, 3 or 4 channels");
  PngImage png;
  png.info.width = image.width();
  png.info.height = image.height();
  png.info.format = image.channels() == 1 ? PNG_FORMAT_GRAY : image.channels() == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png.info);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&png.info, bytes.data(), &size, 0, image.data(), 0, nullptr))
    throw Error(png.info.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace sheen
