// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/image_inspection.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/colour_space.h"
#include "common/image/exif.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

/// Whether all three are alike but for what rounding and lossy coding leave.
bool is_grey(const RawImage& image) {
  constexpr float kWithin = 2;  // of 255
  if (image.format == PixelFormat::kMono8) return true;
  const bool floats = image.format == PixelFormat::kRGB32f;
  const std::size_t pixel_bytes = bytes_per_pixel(image.format);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* at = image.bytes.data() + std::size_t(y) * image.stride;
    for (int x = 0; x < image.width; ++x, at += pixel_bytes) {
      float rgb[3] = {};
      if (floats)
        std::memcpy(rgb, at, sizeof rgb);
      else
        std::copy_n(at, 3, rgb);
      const auto [least, most] = std::minmax({rgb[0], rgb[1], rgb[2]});
      if (most - least > (floats ? kWithin / 255 * std::abs(most) : kWithin)) return false;
    }
  }
  return true;
}

void read_exif(const std::string& bytes, DatasetView& view) {
  view.exif_orientation = read_exif_orientation(bytes);
  const auto exif = read_exif_exposure(bytes);
  if (!exif) return;
  view.exposure_s = exif->exposure_s;
  const double iso = exif->iso > 0 ? exif->iso : 100, f_number = exif->f_number > 0 ? exif->f_number : 1;
  view.gain_db = 20 * std::log10(iso / 100 / (f_number * f_number));
}

}  // namespace

ImageInspection inspect(DatasetView& view) {
  ImageInspection found;
  try {
    const std::string bytes = read_file(view.image_path);
    found.contents = content_hash(bytes);
    read_exif(bytes, view);
    found.other_colours = other_colour_space(bytes);
    const MaskedImage masked = read_masked_image(view.image_path);
    view.image_size = {masked.image.width, masked.image.height};
    found.alpha = !masked.mask.empty();
    found.grey = is_grey(masked.image);
    if (!view.mask_path) {
      found.contents += "no mask";
      return found;
    }
    found.contents += content_hash_of_file(*view.mask_path);
    const ImageU8 mask = read_mask(*view.mask_path);
    view.mask_size = {mask.width(), mask.height()};
  } catch (const Error& error) {
    found.damage = error.what();
  }
  return found;
}

}  // namespace sheen
