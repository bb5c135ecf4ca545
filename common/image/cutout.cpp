// SPDX-License-Identifier: Apache-2.0
#include "common/image/cutout.h"

#include <algorithm>

namespace sheen {

ImageU8 mask_of_alpha(const ImageU8& alpha) {
  constexpr std::uint8_t kHalf = 128;
  const auto covered = [](std::uint8_t a) { return a >= kHalf; };
  if (std::all_of(alpha.data(), alpha.data() + alpha.size(), covered)) return {};
  ImageU8 mask(alpha.width(), alpha.height(), 1);
  std::transform(alpha.data(), alpha.data() + alpha.size(), mask.data(),
                 [&](std::uint8_t a) { return covered(a) ? 255 : 0; });
  return mask;
}

ImageU8 mask_of_drawing(const Cutout& drawing, bool lossy) {
  if (ImageU8 mask = mask_of_alpha(drawing.alpha); !mask.empty()) return mask;
  const ImageU8& colours = drawing.colours;
  ImageU8 mask(colours.width(), colours.height(), 1);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      const std::uint8_t* pixel = colours.pixel(x, y);
      mask.at(x, y) = *std::max_element(pixel, pixel + colours.channels());
    }
  const int brightest = mask.empty() ? 0 : *std::max_element(mask.data(), mask.data() + mask.size());
  const int darkest_object = lossy ? std::max(1, (brightest + 1) / 2) : 1;
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = mask.data()[i] >= darkest_object ? 255 : 0;
  return mask;
}

}  // namespace sheen
