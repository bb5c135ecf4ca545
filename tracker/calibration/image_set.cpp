// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/image_set.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>

#include "common/base/errors.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "tracker/fiducials/tag_detector.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

bool is_image(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png";
}

std::string text_of(const ImageSize& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

constexpr double kBright = 0.995;     ///< the quantile that `light` ...
constexpr double kBrightLevel = 230;  ///< ... puts here

/// Of an image encoded as sRGB.
ImageU8 light_of(const ImageU8& grey) {
  std::array<std::size_t, 256> counts{};
  for (std::size_t i = 0; i < grey.size(); ++i) ++counts[grey.data()[i]];
  std::size_t below = 0, bright = 0;
  while (bright < 255 && double(below += counts[bright]) < kBright * double(grey.size())) ++bright;
  const double gain = kBrightLevel / std::max(srgb_decode(float(bright) / 255), 1e-3f);
  std::array<std::uint8_t, 256> table;
  for (std::size_t value = 0; value < 256; ++value)
    table[value] = static_cast<std::uint8_t>(std::lround(std::min(255.0, gain * srgb_decode(float(value) / 255))));
  ImageU8 light = grey;
  std::transform(grey.data(), grey.data() + grey.size(), light.data(), [&](std::uint8_t v) { return table[v]; });
  return light;
}

}  // namespace

ImageSet find_images(std::span<const fs::path> files_or_folders) {
  ImageSet images;
  for (const fs::path& given : files_or_folders) {
    std::error_code error;
    if (!fs::is_directory(given, error)) {
      images.files.push_back(given);
      continue;
    }
    std::vector<fs::path> inside;
    for (fs::directory_iterator entry(given, error), end; !error && entry != end; entry.increment(error))
      if (is_image(entry->path())) inside.push_back(entry->path());
    if (error) throw FileError(given.string(), "cannot be listed: " + error.message());
    if (inside.empty()) throw FileError(given.string(), "holds no JPEG or PNG image");
    std::ranges::sort(inside);
    images.files.insert(images.files.end(), inside.begin(), inside.end());
  }
  std::set<std::string> names;
  for (const fs::path& file : images.files) names.insert(file.filename().string());
  for (std::size_t i = 0; i < images.files.size(); ++i) {
    const fs::path& file = images.files[i];
    images.names.push_back(names.size() == images.files.size() ? file.filename().string() : file.string());
    const ImageSize size = read_image_size(file);
    if (i == 0) images.size = size;
    if (size.width != images.size.width || size.height != images.size.height)
      throw FileError(file.string(), "is " + text_of(size) + ", " + images.files[0].string() + " is " +
                                         text_of(images.size) + "; give the images of one camera at one size");
  }
  return images;
}

GreyImage grey_image(const RawImage& image) {
  GreyImage both{detection_image(image), {}};
  both.light = image.transfer == Transfer::kSrgb ? light_of(both.grey) : both.grey;
  return both;
}

void for_each_image(const ImageSet& images, const std::function<void(std::size_t, const GreyImage&)>& see) {
  for (std::size_t i = 0; i < images.files.size(); ++i) {
    see(i, grey_image(read_image(images.files[i])));
  }
}

}  // namespace sheen
