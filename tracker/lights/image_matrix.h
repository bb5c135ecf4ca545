// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"

namespace cv {
class Mat;
}

namespace sheen {

/// An image of one channel as OpenCV sees it: the pixels are the image's own, which must outlive it.
cv::Mat wrapped(const ImageF& image);
cv::Mat wrapped(const ImageU8& image);

/// Of the values of a matrix of floats, of which there must be one; `q` in 0..1.
float quantile(const cv::Mat& values, double q);

}  // namespace sheen
