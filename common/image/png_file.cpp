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
  void read(png_uint_32 format, void* pixels, void* colours = nullptr) {
    info.format = format;
    if (!png_image_finish_read(&info, nullptr, pixels, 0, colours)) fail();
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

Cutout read_cutout(PngImage& png) {
  // Of 16 bits the upper 8, which are sRGB unless the file says otherwise, as those of photographs are.
  png.info.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  const bool colour = png.has(PNG_FORMAT_FLAG_COLOR);
  const int colours = colour ? 3 : 1;
  Cutout out{ImageU8(png.width(), png.height(), colours), {}};
  if (!png.has(PNG_FORMAT_FLAG_ALPHA)) {
    png.read(colour ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY, out.colours.data());
    return out;
  }
  // Read with alpha: libpng would else blend it with a background.
  ImageU8 pixels(png.width(), png.height(), colours + 1);
  png.read(colour ? PNG_FORMAT_RGBA : PNG_FORMAT_GA, pixels.data());
  out.alpha = ImageU8(png.width(), png.height(), 1);
  for (std::size_t i = 0; i < out.alpha.size(); ++i) {
    const std::uint8_t* pixel = pixels.data() + i * std::size_t(colours + 1);
    std::copy_n(pixel, colours, out.colours.data() + i * std::size_t(colours));
    out.alpha.data()[i] = pixel[colours];
  }
  return out;
}

/// A drawing in which 0 is background: the numbers of a palette's entries, or their colours where those say it.
Cutout read_palette_drawing(PngImage& png) {
  struct Entry {
    std::uint8_t r, g, b, a;
    bool black() const { return r == 0 && g == 0 && b == 0; }
  };
  std::vector<Entry> entries(256, Entry{});
  const std::size_t used = png.info.colormap_entries;
  ImageU8 numbers(png.width(), png.height(), 1);
  png.read(PNG_FORMAT_RGBA_COLORMAP, numbers.data(), entries.data());
  const bool by_number =
      entries[0].black() || std::none_of(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(used),
                                         [](const Entry& entry) { return entry.black(); });
  Cutout out{ImageU8(png.width(), png.height(), 1), ImageU8(png.width(), png.height(), 1)};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::uint8_t number = numbers.data()[i];
    const Entry& entry = entries[number];
    out.colours.data()[i] = by_number ? number : entry.black() ? 0 : 255;
    out.alpha.data()[i] = entry.a;
  }
  return out;
}

/// The same of 16 bits: 255 where a sample is not 0.
Cutout read_deep_drawing(PngImage& png) {
  Image<std::uint16_t> samples(png.width(), png.height(), 4);
  png.read(PNG_FORMAT_LINEAR_RGB_ALPHA, samples.data());  // the colours are multiplied by alpha
  Cutout out{ImageU8(png.width(), png.height(), 1), ImageU8(png.width(), png.height(), 1)};
  for (std::size_t i = 0; i < out.alpha.size(); ++i) {
    const std::uint16_t* pixel = samples.data() + 4 * i;
    out.colours.data()[i] = std::max({pixel[0], pixel[1], pixel[2]}) > 0 ? 255 : 0;
    out.alpha.data()[i] = static_cast<std::uint8_t>(pixel[3] >> 8);
  }
  return out;
}

}  // namespace

Cutout decode_png(std::string_view bytes) {
  PngImage png;
  begin(png, bytes);
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
