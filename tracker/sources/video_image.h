// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "common/image/raw_image.h"

namespace cv {
class Mat;
}

namespace sheen {

/// The sRGB image of what a video decoder gives: 8 bits, blue first. Nothing where it is no such image.
std::optional<RawImage> image_of_video(const cv::Mat& bgr);

}  // namespace sheen
