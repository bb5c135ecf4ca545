// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/weiss.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr float kDelta = 2e-3f;  // of log(I + delta): half a step of an 8-bit image near black

/// One channel of log I, of even size as the cosine transform wants it: the last row or column stands twice.
cv::Mat log_channel(const ImageF& image, int channel) {
  const int w = image.width() + image.width() % 2, h = image.height() + image.height() % 2;
  cv::Mat out(h, w, CV_32FC1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      out.at<float>(y, x) =
          std::log(image.at(std::min(x, image.width() - 1), std::min(y, image.height() - 1), channel) + kDelta);
  return out;
}

/// The picture whose differences to the right are `right` and downwards `down`, by least squares; its mean is 0.
cv::Mat integrate(const cv::Mat& right, const cv::Mat& down) {
  const int w = right.cols, h = right.rows;
  cv::Mat divergence = cv::Mat::zeros(h, w, CV_32FC1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float& d = divergence.at<float>(y, x);
      if (x + 1 < w) d += right.at<float>(y, x);
      if (x > 0) d -= right.at<float>(y, x - 1);
      if (y + 1 < h) d += down.at<float>(y, x);
      if (y > 0) d -= down.at<float>(y - 1, x);
    }
  cv::Mat frequencies, out;
  cv::dct(divergence, frequencies);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const double bend = 2 * std::cos(M_PI * x / w) + 2 * std::cos(M_PI * y / h) - 4;
      float& f = frequencies.at<float>(y, x);
      f = x == 0 && y == 0 ? 0 : static_cast<float>(f / bend);
    }
  cv::idct(frequencies, out);
  return out;
}

void estimate_channel(std::span<const ImageF> radiance, int channel, ImageF& reflectance) {
  std::vector<cv::Mat> logs;
  for (const ImageF& image : radiance) logs.push_back(log_channel(image, channel));
  const int w = logs[0].cols, h = logs[0].rows;
  cv::Mat right = cv::Mat::zeros(h, w, CV_32FC1), down = right.clone(), middle = right.clone();
  tbb::parallel_for(0, h, [&](int y) {
    std::vector<float> values(logs.size());
    const auto median_of = [&](const auto& value) {
      values.resize(logs.size());
      for (std::size_t n = 0; n < logs.size(); ++n) values[n] = value(logs[n]);
      return median_of_both_middles<float>(values);
    };
    for (int x = 0; x < w; ++x) {
      middle.at<float>(y, x) = median_of([&](const cv::Mat& i) { return i.at<float>(y, x); });
      if (x + 1 < w)
        right.at<float>(y, x) = median_of([&](const cv::Mat& i) { return i.at<float>(y, x + 1) - i.at<float>(y, x); });
      if (y + 1 < h)
        down.at<float>(y, x) = median_of([&](const cv::Mat& i) { return i.at<float>(y + 1, x) - i.at<float>(y, x); });
    }
  });
  const cv::Mat log_reflectance = integrate(right, down);
  const auto level = static_cast<float>(cv::mean(middle)[0]);
  for (int y = 0; y < reflectance.height(); ++y)
    for (int x = 0; x < reflectance.width(); ++x)
      reflectance.at(x, y, channel) = std::exp(log_reflectance.at<float>(y, x) + level);
}

}  // namespace

ImageF estimate_reflectance(std::span<const ImageF> radiance) {
  ImageF reflectance(radiance[0].width(), radiance[0].height(), 3);
  for (int channel = 0; channel < 3; ++channel) estimate_channel(radiance, channel, reflectance);
  return reflectance;
}

float otsu_threshold(const ImageF& values, const ImageU8& mask) {
  constexpr std::size_t kBins = 256;
  const auto counts = [&](std::size_t i) { return mask.empty() || mask.data()[i] != 0; };
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (counts(i)) {
      low = std::min(low, values.data()[i]);
      high = std::max(high, values.data()[i]);
    }
  if (!(high > low)) return low;
  std::vector<double> histogram(kBins);
  const auto bin_of = [&](float v) {
    return std::min(kBins - 1, static_cast<std::size_t>((v - low) / (high - low) * static_cast<float>(kBins)));
  };
  double total = 0, sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (counts(i)) {
      const std::size_t bin = bin_of(values.data()[i]);
      ++histogram[bin];
      ++total;
      sum += static_cast<double>(bin);
    }
  double below = 0, sum_below = 0, best = -1;
  std::size_t best_bin = 0;
  for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
    below += histogram[bin];
    sum_below += histogram[bin] * static_cast<double>(bin);
    if (below == 0 || below == total) continue;
    const double apart = sum_below / below - (sum - sum_below) / (total - below);
    const double scatter = below * (total - below) * apart * apart;
    if (scatter > best) {
      best = scatter;
      best_bin = bin;
    }
  }
  return low + (high - low) * static_cast<float>(best_bin + 1) / static_cast<float>(kBins);
}

}  // namespace sheen
