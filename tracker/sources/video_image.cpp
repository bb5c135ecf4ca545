// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_image.h"

#include <opencv2/imgproc.hpp>

namespace sheen {

std::optional<RawImage> image_of_video(const cv::Mat& bgr) {
  if (bgr.type() != CV_8UC3) return std::nullopt;
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return RawImage{.format = PixelFormat::kRGB8,
                  .transfer = Transfer::kSrgb,
                  .width = rgb.cols,
                  .height = rgb.rows,
                  .stride = std::size_t(rgb.cols) * 3,
                  .bytes = std::vector<std::uint8_t>(rgb.data, rgb.data + rgb.total() * 3)};
}

}  // namespace sheen
