// SPDX-License-Identifier: Apache-2.0
#include "common/image/jpeg.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <jpeglib.h>
// behind jpeglib.h
#include <jerror.h>

#include "common/base/errors.h"

namespace sheen {

namespace {

/// libjpeg reports fatal errors by a call that must not return. Between `setjmp` and the jump only plain C objects
/// live.
struct ErrorTrap {
  jpeg_error_mgr manager;
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

void trap_error(j_common_ptr info) {
  auto* trap = reinterpret_cast<ErrorTrap*>(info->err);
  trap->manager.format_message(info, trap->message);
  std::longjmp(trap->jump, 1);
}

/// libjpeg fills lost parts with grey and goes on; here that is an error. Oddities that lose nothing are let pass.
void trap_lost_data(j_common_ptr info, int level) {
  if (level >= 0) return;
  switch (info->err->msg_code) {
    case JWRN_HIT_MARKER:
    case JWRN_JPEG_EOF:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_ARITH_BAD_CODE:
    case JWRN_MUST_RESYNC:
    case JWRN_BOGUS_PROGRESSION:
      trap_error(info);
  }
}

jpeg_error_mgr* install(ErrorTrap& trap) {
  jpeg_std_error(&trap.manager);
  trap.manager.error_exit = trap_error;
  trap.manager.emit_message = trap_lost_data;
  return &trap.manager;
}

struct Header {
  ImageSize size;
  int channels = 0;
};

/// Reads the header and, given `pixels`, the picture. False: see the trap's message.
bool decode(ErrorTrap& trap, std::string_view bytes, Header& header, std::uint8_t* pixels) {
  jpeg_decompress_struct info;
  info.err = install(trap);
  if (setjmp(trap.jump)) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  const bool grey = info.jpeg_color_space == JCS_GRAYSCALE;
  const bool colour = info.jpeg_color_space == JCS_YCbCr || info.jpeg_color_space == JCS_RGB;
  header = {{int(info.image_width), int(info.image_height)}, grey ? 1 : colour ? 3 : 0};
  if (pixels && header.channels > 0) {
    info.out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      JSAMPROW row = pixels + std::size_t(info.output_scanline) * info.output_width * header.channels;
      jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
  }
  jpeg_destroy_decompress(&info);
  return true;
}

Header decode_header(std::string_view bytes) {
  ErrorTrap trap;
  Header header;
  if (!decode(trap, bytes, header, nullptr)) throw Error(std::string("damaged JPEG: ") + trap.message);
  if (header.channels == 0) throw Error("a JPEG of neither grey nor RGB colours (CMYK?) cannot be read");
  // Even a flat picture takes a bit for each block of 8 x 8; a header that claims more must not be given the memory.
  constexpr double kPixelsPerByte = 2048, kSlack = 1 << 20;
  if (double(header.size.width) * header.size.height > kSlack + kPixelsPerByte * double(bytes.size()))
    throw Error("claims " + std::to_string(header.size.width) + " x " + std::to_string(header.size.height) +
                " pixels, more than the file can hold");
  return header;
}

bool encode(ErrorTrap& trap, const ImageU8& image, int quality, unsigned char** bytes, unsigned long* size) {
  jpeg_compress_struct info;
  info.err = install(trap);
  if (setjmp(trap.jump)) {
    jpeg_destroy_compress(&info);
    return false;
  }
  jpeg_create_compress(&info);
  jpeg_mem_dest(&info, bytes, size);
  info.image_width = image.width();
  info.image_height = image.height();
  info.input_components = image.channels();
  info.in_color_space = image.channels() == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row = const_cast<std::uint8_t*>(image.row(int(info.next_scanline)));
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  return true;
}

}  // namespace

ImageU8 decode_jpeg(std::string_view bytes) {
  Header header = decode_header(bytes);
  ImageU8 image(header.size.width, header.size.height, header.channels);
  ErrorTrap trap;
  if (!decode(trap, bytes, header, image.data())) throw Error(std::string("damaged JPEG: ") + trap.message);
  return image;
}

ImageSize decode_jpeg_size(std::string_view bytes) {
  return decode_header(bytes).size;
}

std::vector<std::uint8_t> encode_jpeg(const ImageU8& image, int quality) {
  if (image.empty() || (image.channels() != 1 && image.channels() != 3) || quality < 1 || quality > 100)
    throw Error("a JPEG needs pixels of 1 or 3 channels and a quality of 1..100");
  ErrorTrap trap;
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const bool good = encode(trap, image, quality, &bytes, &size);
  const std::unique_ptr<unsigned char, decltype(&std::free)> owner(bytes, &std::free);
  if (!good) throw Error(std::string("JPEG: ") + trap.message);
  return {bytes, bytes + size};
}

}  // namespace sheen
