// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/outline_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace sheen {

ImageF distance_from_outline(const ShapeView& view) {
  const ImageU8& outline = view.outline;
  if (outline.empty()) return {};
  cv::Mat background(outline.height(), outline.width(), CV_8U);
  bool any_object = false;
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x) {
      const auto mark = static_cast<Outline>(outline.at(x, y));
      background.at<std::uint8_t>(y, x) = mark == Outline::kBackground ? 255 : 0;
      any_object = any_object || mark == Outline::kObject;
    }
  if (!any_object || cv::countNonZero(background) == 0) return {};
  cv::Mat outside, inside;
  cv::distanceTransform(background, outside, cv::DIST_L2, cv::DIST_MASK_5, CV_32F);
  cv::bitwise_not(background, background);
  cv::distanceTransform(background, inside, cv::DIST_L2, cv::DIST_MASK_5, CV_32F);
  ImageF distance(outline.width(), outline.height(), 1);
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x) {
      const float out = outside.at<float>(y, x), in = inside.at<float>(y, x);
      distance.at(x, y) = out > 0 ? out - 0.5f : 0.5f - in;
      if (view.before_sheet && outline.at(x, y) == static_cast<std::uint8_t>(Outline::kUnknown))
        distance.at(x, y) = std::numeric_limits<float>::quiet_NaN();
    }
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
