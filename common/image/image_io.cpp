// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_io.h"

#include <png.h>

#include <algorithm>
#include <cstring>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/exr.h"
#include "common/image/jpeg.h"
#include "common/image/webp.h"

namespace sheen {

namespace {

enum class FileKind { kJpeg, kPng, kWebp, kExr };

FileKind kind_of(const std::filesystem::path& path, std::string_view bytes) {
  if (bytes.starts_with("\xFF\xD8\xFF")) return FileKind::kJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1A\n")) return FileKind::kPng;
  if (bytes.starts_with(std::string_view("\x76\x2F\x31\x01", 4))) return FileKind::kExr;
  if (bytes.size() > 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP") return FileKind::kWebp;
  throw FileError(path.string(), bytes.empty() ? "is empty" : "is neither JPEG nor PNG nor WebP nor EXR");
}

/// libpng's own structure with its clean-up.
struct PngImage {
  png_image info{};
  PngImage() { info.version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(&info); }
  [[noreturn]] void fail() const { throw Error(std::string("damaged PNG: ") + info.message); }
};

void begin_png(PngImage& png, std::string_view bytes) {
  if (!png_image_begin_read_from_memory(&png.info, bytes.data(), bytes.size())) png.fail();
  if (png.info.format & PNG_FORMAT_FLAG_LINEAR)
    throw Error("a PNG of 16 bits per channel cannot be read; write 8 bits, or EXR for more");
  // Deflate packs at most 1032 : 1; a header that claims more must not be given the memory.
  const double claimed = double(png.info.width) * png.info.height * PNG_IMAGE_SAMPLE_CHANNELS(png.info.format);
  if (claimed / 8 > 1100.0 * double(bytes.size()))  // 1 bit per sample is the least
    throw Error("claims " + std::to_string(png.info.width) + " x " + std::to_string(png.info.height) +
                " pixels, more than the file can hold");
}

ImageU8 decode_png(std::string_view bytes) {
  PngImage png;
  begin_png(png, bytes);
  const bool colour = png.info.format & PNG_FORMAT_FLAG_COLOR;
  const int channels = colour ? 3 : 1;
  const int width = int(png.info.width), height = int(png.info.height);
  ImageU8 image(width, height, channels);
  // Read with alpha where there is one: libpng would else blend it with a background.
  const bool alpha = png.info.format & PNG_FORMAT_FLAG_ALPHA;
  png.info.format = colour ? (alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB) : (alpha ? PNG_FORMAT_GA : PNG_FORMAT_GRAY);
  std::vector<std::uint8_t> with_alpha(alpha ? PNG_IMAGE_SIZE(png.info) : 0);
  if (!png_image_finish_read(&png.info, nullptr, alpha ? with_alpha.data() : image.data(), 0, nullptr)) png.fail();
  if (alpha)
    for (std::size_t i = 0; i < std::size_t(width) * height; ++i)
      std::copy_n(&with_alpha[i * (channels + 1)], channels, image.data() + i * channels);
  return image;
}

RawImage raw_from_u8(const ImageU8& image) {
  RawImage raw;
  raw.format = image.channels() == 1 ? PixelFormat::kMono8 : PixelFormat::kRGB8;
  raw.transfer = Transfer::kSrgb;
  raw.width = image.width();
  raw.height = image.height();
  raw.stride = std::size_t(image.width()) * image.channels();
  raw.bytes.assign(image.data(), image.data() + image.size());
  return raw;
}

/// Red, green and blue of an EXR part: its R, G, B (of whatever layer), else its only channel three times.
RawImage raw_from_exr(const std::filesystem::path& path) {
  const ExrFile file = read_exr(path);
  const ExrPart& part = file.parts[0];
  const auto channel = [&](const std::string& name) {
    const auto found = std::find_if(part.channels.begin(), part.channels.end(),
                                    [&](const std::string& c) { return c == name || c.ends_with("." + name); });
    return found == part.channels.end() ? -1 : int(found - part.channels.begin());
  };
  int rgb[3] = {channel("R"), channel("G"), channel("B")};
  if (part.channels.size() == 1) rgb[0] = rgb[1] = rgb[2] = 0;
  if (rgb[0] < 0 || rgb[1] < 0 || rgb[2] < 0)
    throw FileError(path.string(), "its first part has neither channels R, G, B nor a single one");
  if (part.left != 0 || part.top != 0)
    throw FileError(path.string(), "is a crop (its data window does not start where its display window does)");
  RawImage raw;
  raw.format = PixelFormat::kRGB32f;
  raw.transfer = Transfer::kLinear;
  raw.width = part.image.width();
  raw.height = part.image.height();
  raw.stride = std::size_t(raw.width) * 3 * sizeof(float);
  raw.bytes.resize(raw.stride * raw.height);
  std::uint8_t* out = raw.bytes.data();
  for (std::size_t i = 0; i < part.image.size(); i += part.channels.size())
    for (const int c : rgb) {
      std::memcpy(out, part.image.data() + i + c, sizeof(float));
      out += sizeof(float);
    }
  return raw;
}

/// Calls `read` and puts the file's name before what it throws.
template <typename Read>
auto naming(const std::filesystem::path& path, Read read) {
  try {
    return read();
  } catch (const FileError&) {
    throw;
  } catch (const Error& error) {
    throw FileError(path.string(), error.what());
  }
}

ImageU8 decode_u8(const std::filesystem::path& path, FileKind kind, std::string_view bytes) {
  return naming(path, [&] {
    if (kind == FileKind::kWebp) return decode_webp(bytes);
    return kind == FileKind::kJpeg ? decode_jpeg(bytes) : decode_png(bytes);
  });
}

}  // namespace

RawImage read_image(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const FileKind kind = kind_of(path, bytes);
  return kind == FileKind::kExr ? raw_from_exr(path) : raw_from_u8(decode_u8(path, kind, bytes));
}

ImageSize read_image_size(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  switch (kind_of(path, bytes)) {
    case FileKind::kJpeg:
      return naming(path, [&] { return decode_jpeg_size(bytes); });
    case FileKind::kPng:
      return naming(path, [&] {
        PngImage png;
        begin_png(png, bytes);
        return ImageSize{int(png.info.width), int(png.info.height)};
      });
    case FileKind::kWebp:
      return naming(path, [&] { return decode_webp_size(bytes); });
    case FileKind::kExr:
      break;
  }
  const RawImage image = raw_from_exr(path);
  return {image.width, image.height};
}

ImageU8 read_mask(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const FileKind kind = kind_of(path, bytes);
  if (kind == FileKind::kExr) throw FileError(path.string(), "a mask must be an 8-bit image");
  const ImageU8 image = decode_u8(path, kind, bytes);
  if (image.channels() == 1) return image;
  ImageU8 mask(image.width(), image.height(), 1);
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = image.data()[i * image.channels()];
  return mask;
}

void write_png(const std::filesystem::path& path, const ImageU8& image) {
  if (image.empty() || (image.channels() != 1 && image.channels() != 3 && image.channels() != 4))
    throw FileError(path.string(), "cannot be written: a PNG needs pixels of 1, 3 or 4 channels");
  PngImage png;
  png.info.width = image.width();
  png.info.height = image.height();
  png.info.format = image.channels() == 1 ? PNG_FORMAT_GRAY : image.channels() == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png.info);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&png.info, bytes.data(), &size, 0, image.data(), 0, nullptr))
    throw FileError(path.string(), std::string("cannot be written: ") + png.info.message);
  write_file(path, std::string_view(bytes).substr(0, size));
}

}  // namespace sheen
