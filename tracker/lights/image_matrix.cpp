// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/image_matrix.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

namespace sheen {

cv::Mat wrapped(const ImageF& image) {
  return {image.height(), image.width(), CV_32F, const_cast<float*>(image.data())};
}

cv::Mat wrapped(const ImageU8& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())};
}

float quantile(const cv::Mat& values, double q) {
  std::vector<float> all(values.begin<float>(), values.end<float>());
  const auto at = all.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(all.size() - 1));
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

}  // namespace sheen
