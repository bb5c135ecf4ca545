// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_io.h"

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/exr_picture.h"
#include "common/image/jpeg.h"
#include "common/image/png_file.h"
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

Cutout decode(FileKind kind, std::string_view bytes) {
  if (kind == FileKind::kWebp) return decode_webp_cutout(bytes);
  return kind == FileKind::kPng ? decode_png(bytes) : Cutout{decode_jpeg(bytes), {}};
}

}  // namespace

MaskedImage read_masked_image(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const FileKind kind = kind_of(path, bytes);
  if (kind == FileKind::kExr) return read_exr_picture(path);
  const Cutout cutout = naming(path, [&] { return decode(kind, bytes); });
  return {raw_from_u8(cutout.colours), mask_of_alpha(cutout.alpha)};
}

RawImage read_image(const std::filesystem::path& path) {
  return read_masked_image(path).image;
}

ImageSize read_image_size(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const FileKind kind = kind_of(path, bytes);
  if (kind == FileKind::kExr) return read_exr_picture_size(path);
  return naming(path, [&] {
    if (kind == FileKind::kWebp) return decode_webp_size(bytes);
    return kind == FileKind::kPng ? decode_png_size(bytes) : decode_jpeg_size(bytes);
  });
}

ImageU8 read_mask(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  const FileKind kind = kind_of(path, bytes);
  if (kind == FileKind::kExr) throw FileError(path.string(), "a mask must be an 8-bit image: JPEG, PNG or WebP");
  return naming(path, [&] {
    if (kind == FileKind::kWebp) return decode_webp_mask(bytes);
    return kind == FileKind::kPng ? decode_png_mask(bytes) : mask_of_drawing({decode_jpeg(bytes), {}}, /*lossy=*/true);
  });
}

void write_png(const std::filesystem::path& path, const ImageU8& image) {
  try {
    write_file(path, encode_png(image));
  } catch (const FileError&) {
    throw;
  } catch (const Error& error) {
    throw FileError(path.string(), std::string("cannot be written: ") + error.what());
  }
}

}  // namespace sheen
