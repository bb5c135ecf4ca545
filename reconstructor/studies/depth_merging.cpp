// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/depth_merging.h"

#include <opencv2/imgproc.hpp>

namespace sheen {
namespace {

constexpr double kNoConfidence = 1e-12;
constexpr int kWindow = 5;  // pixels along a side

}  // namespace

ImageF merge_depths(std::span<const ImageF> depths, std::span<const ImageF> confidences) {
  ImageF merged(depths[0].width(), depths[0].height(), 1);
  for (std::size_t i = 0; i < merged.size(); ++i) {
    double weights = kNoConfidence, sum = kNoConfidence * depths[0].data()[i];
    for (std::size_t n = 0; n < depths.size(); ++n) {
      sum += static_cast<double>(confidences[n].data()[i]) * depths[n].data()[i];
      weights += confidences[n].data()[i];
    }
    merged.data()[i] = static_cast<float>(sum / weights);
  }
  return merged;
}

ImageF texture_confidence(const ImageF& grey) {
  ImageF out(grey.width(), grey.height(), 1);
  const cv::Mat values(grey.height(), grey.width(), CV_32FC1, const_cast<float*>(grey.data()));
  cv::Mat eigenvalue(out.height(), out.width(), CV_32FC1, out.data());
  cv::cornerMinEigenVal(values, eigenvalue, kWindow);
  return out;
}

}  // namespace sheen
