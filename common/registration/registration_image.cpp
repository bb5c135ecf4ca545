// SPDX-License-Identifier: Apache-2.0
#include "common/registration/registration_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/capture/linear_capture.h"
#include "common/image/color.h"

namespace sheen {
namespace {

constexpr double kSurroundings_px = 2.5;  // standard deviation of the window, at each level
constexpr float kNoise = 0.01f;           // encoded: contrast below it counts as this much
constexpr int kSmallestSide_px = 24;      // of the coarsest level

template <typename T>
cv::Mat header(const Image<T>& image, int type) {
  return {image.height(), image.width(), type, const_cast<T*>(image.data())};
}

template <typename T>
Image<T> halved(const Image<T>& image, int type) {
  Image<T> half(image.width() / 2, image.height() / 2, 1);
  cv::Mat out = header(half, type);
  const cv::Rect even(0, 0, 2 * half.width(), 2 * half.height());
  cv::resize(header(image, type)(even), out, out.size(), 0, 0, cv::INTER_AREA);
  return half;
}

/// What differs from the surroundings, over their contrast.
ImageF detail_of(const ImageF& image) {
  const cv::Mat value = header(image, CV_32F);
  cv::Mat mean, square, mean_square;
  cv::GaussianBlur(value, mean, {}, kSurroundings_px);
  cv::multiply(value, value, square);
  cv::GaussianBlur(square, mean_square, {}, kSurroundings_px);
  ImageF detail(image.width(), image.height(), 1);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const float m = mean.at<float>(y, x), variance = std::max(0.0f, mean_square.at<float>(y, x) - m * m);
      detail.at(x, y) = (image.at(x, y) - m) / std::sqrt(variance + kNoise * kNoise);
    }
  return detail;
}

}  // namespace

RegistrationImage registration_image(const Capture& capture) {
  RegistrationImage image{.name = capture.name, .view = {capture.camera, capture.pose.camera_from_object}};
  const ImageF linear = linear_radiance(capture);
  image.grey = ImageF(linear.width(), linear.height(), 1);
  for (std::size_t i = 0; i < image.grey.size(); ++i) {
    const float value = luminance(linear.data() + 3 * i);
    image.grey.data()[i] = std::isfinite(value) ? std::max(value, 0.0f) : 0.0f;
  }
  srgb_encode_fast({image.grey.data(), image.grey.size()});
  image.mask = capture.mask;
  for (std::size_t i = 0; i < image.mask.size(); ++i) image.mask.data()[i] = image.mask.data()[i] != 0 ? 255 : 0;
  while (image.grey.width() > kWidestRegistration_px) {
    // An odd last row or column is left out: the camera keeps its scale of exactly one half.
    Camera& c = image.view.camera;
    c.width = image.grey.width() / 2 * 2;
    c.height = image.grey.height() / 2 * 2;
    c = c.scaled(c.width / 2, c.height / 2);
    image.grey = halved(image.grey, CV_32F);
    if (!image.mask.empty()) image.mask = halved(image.mask, CV_8U);
  }
  for (std::size_t i = 0; i < image.mask.size(); ++i) image.mask.data()[i] = image.mask.data()[i] >= 128 ? 255 : 0;
  return image;
}

DetailPyramid::DetailPyramid(const ImageF& grey, int finest) {
  ImageF smaller;
  for (const ImageF* level = &grey;; level = &smaller) {
    levels_.push_back(this->levels() < finest ? ImageF() : detail_of(*level));
    if (std::min(level->width(), level->height()) < 2 * kSmallestSide_px) return;
    smaller = halved(*level, CV_32F);
  }
}

bool DetailPyramid::sample(int level, double x, double y, float& value, Eigen::Vector2f& gradient) const {
  if (level >= levels()) return false;
  const ImageF& image = levels_[level];
  const auto scale = static_cast<float>(1.0 / (1 << level));
  const float u = (static_cast<float>(x) + 0.5f) * scale - 0.5f, v = (static_cast<float>(y) + 0.5f) * scale - 0.5f;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(image.width() - 1) && v < static_cast<float>(image.height() - 1)))
    return false;
  const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
  const float s = u - static_cast<float>(x0), t = v - static_cast<float>(y0);
  const float *a = image.pixel(x0, y0), *b = image.pixel(x0, y0 + 1);
  value = (1 - t) * ((1 - s) * a[0] + s * a[1]) + t * ((1 - s) * b[0] + s * b[1]);
  gradient =
      scale * Eigen::Vector2f((1 - t) * (a[1] - a[0]) + t * (b[1] - b[0]), (1 - s) * (b[0] - a[0]) + s * (b[1] - a[1]));
  return true;
}

}  // namespace sheen
