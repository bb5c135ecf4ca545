// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/image_matrix.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "common/base/order_statistics.h"

namespace sheen {

cv::Mat wrapped(const ImageF& image) {
  return {image.height(), image.width(), CV_32F, const_cast<float*>(image.data())};
}

cv::Mat wrapped(const ImageU8& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())};
}

float quantile(const cv::Mat& values, double q) {
  return quantile(std::vector<float>(values.begin<float>(), values.end<float>()), q);
}

}  // namespace sheen
