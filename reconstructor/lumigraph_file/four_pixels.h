// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "common/image/image.h"

namespace sheen {

/// The four pixels round a place of a view's image, those of the border where it is beside it, and their bilinear
/// weights: found once for all images of a view.
class FourPixels {
 public:
  /// `z`: depth of the point that is looked for. Pixels that show nothing do not count.
  FourPixels(const ImageF& depth, const Eigen::Vector2d& place, double z) {
    const auto left = static_cast<int>(std::floor(place.x())), top = static_cast<int>(std::floor(place.y()));
    const auto u = static_cast<float>(place.x() - left), v = static_cast<float>(place.y() - top);
    const int x0 = std::clamp(left, 0, depth.width() - 1), x1 = std::clamp(left + 1, 0, depth.width() - 1);
    const std::size_t y0 = row(depth, top), y1 = row(depth, top + 1);
    pixels_ = {y0 + x0, y0 + x1, y1 + x0, y1 + x1};
    weights_ = {(1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u};
    float sum = 0;
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
      const double here = depth.data()[pixels_[k]];
      show_[k] = std::abs(here - z) <= kSameDepth * z;
      if (!(here > 0)) weights_[k] = 0;
      sum += weights_[k];
    }
    if (!(sum > 0)) return;
    for (float& weight : weights_) weight /= sum;
  }

  /// Whether one of them shows a surface as deep as the point.
  bool seen() const {
    return std::any_of(show_.begin(), show_.end(), [](bool shows) { return shows; });
  }
  /// The weights sum to 1, but for a view that shows nothing there.
  Eigen::Vector3f mean(const ImageF& rgb) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < pixels_.size(); ++k)
      sum += weights_[k] * Eigen::Vector3f::Map(rgb.data() + 3 * pixels_[k]);
    return sum;
  }
  /// Calls `visit(pixel, weight)` for those that show a surface as deep as the point.
  template <typename Visit>
  void for_each_that_shows(const Visit& visit) const {
    for (std::size_t k = 0; k < pixels_.size(); ++k)
      if (show_[k] && weights_[k] > 0) visit(pixels_[k], weights_[k]);
  }

 private:
  static constexpr double kSameDepth = 0.01;  // of the depth

  static std::size_t row(const ImageF& image, int y) {
    return static_cast<std::size_t>(std::clamp(y, 0, image.height() - 1)) * image.width();
  }

  std::array<std::size_t, 4> pixels_;
  std::array<float, 4> weights_;
  std::array<bool, 4> show_{};
};

}  // namespace sheen
