// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/outline_distance.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "common/registration/silhouette.h"

namespace sheen {

ImageF distance_from_rim(const ImageU8& outline, Outline least) {
  ImageU8 mask(outline.width(), outline.height(), 1);
  std::transform(outline.data(), outline.data() + outline.size(), mask.data(),
                 [&](std::uint8_t mark) { return mark >= static_cast<std::uint8_t>(least) ? 255 : 0; });
  const auto end = mask.data() + mask.size();
  if (std::find(mask.data(), end, 255) == end || std::find(mask.data(), end, 0) == end) return {};
  ImageF distance = distance_from_outline(mask);
  std::transform(distance.data(), distance.data() + distance.size(), distance.data(), std::negate<>());
  return distance;
}

ImageF distance_from_background(const ShapeView& view) {
  const ImageU8& outline = view.outline;
  const auto end = outline.data() + outline.size();
  if (std::find(outline.data(), end, static_cast<std::uint8_t>(Outline::kObject)) == end) return {};
  ImageF distance = distance_from_rim(outline, Outline::kUnknown);
  if (!distance.empty() && view.before_sheet)
    for (int y = 0; y < outline.height(); ++y)
      for (int x = 0; x < outline.width(); ++x)
        if (outline.at(x, y) == static_cast<std::uint8_t>(Outline::kUnknown))
          distance.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  return distance;
}

float bilinear(const ImageF& image, float x, float y) {
  const float u = std::clamp(x, 0.0f, static_cast<float>(image.width() - 1));
  const float v = std::clamp(y, 0.0f, static_cast<float>(image.height() - 1));
  const int x0 = std::min(static_cast<int>(u), std::max(0, image.width() - 2));
  const int y0 = std::min(static_cast<int>(v), std::max(0, image.height() - 2));
  const int x1 = std::min(x0 + 1, image.width() - 1), y1 = std::min(y0 + 1, image.height() - 1);
  const float s = u - static_cast<float>(x0), t = v - static_cast<float>(y0);
  return (1 - t) * ((1 - s) * image.at(x0, y0) + s * image.at(x1, y0)) +
         t * ((1 - s) * image.at(x0, y1) + s * image.at(x1, y1));
}

}  // namespace sheen
