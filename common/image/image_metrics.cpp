// SPDX-License-Identifier: Apache-2.0
#include "common/image/image_metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "common/base/errors.h"

namespace sheen {

namespace {

constexpr double kPeak = 255;
constexpr int kRadius = 5;  ///< of the 11 x 11 window

template <typename A, typename B>
void check_same_size(const Image<A>& a, const Image<B>& b, const char* what) {
  if (a.width() != b.width() || a.height() != b.height())
    throw Error(std::string(what) + " differ in size: " + std::to_string(a.width()) + " x " +
                std::to_string(a.height()) + " and " + std::to_string(b.width()) + " x " + std::to_string(b.height()));
}

void check_comparable(const ImageU8& a, const ImageU8& b, const ImageU8& mask) {
  check_same_size(a, b, "images to be compared");
  if (a.channels() != b.channels()) throw Error("images to be compared differ in their number of channels");
  if (!mask.empty()) check_same_size(a, mask, "image and mask");
}

std::array<float, 2 * kRadius + 1> gaussian_window() {
  constexpr double kSigma = 1.5;
  std::array<float, 2 * kRadius + 1> window;
  for (int i = -kRadius; i <= kRadius; ++i)
    window[i + kRadius] = static_cast<float>(std::exp(-i * i / (2 * kSigma * kSigma)));
  return window;
}

/// One over the weight of the window that is left inside 0..size-1 at each place.
std::vector<float> window_normalisation(const std::array<float, 2 * kRadius + 1>& window, int size) {
  std::vector<float> out(size);
  for (int x = 0; x < size; ++x) {
    float sum = 0;
    for (int i = std::max(-kRadius, -x); i <= std::min(kRadius, size - 1 - x); ++i) sum += window[i + kRadius];
    out[x] = 1 / sum;
  }
  return out;
}

/// Moments of the values less 128, which keeps float sums of squares exact enough: E a, E b, E aa, E bb, E ab.
constexpr int kMoments = 5;
constexpr float kOffset = 128;

/// SSIM of one pixel from its window's moments.
double pixel_ssim(const std::array<float, kMoments>& m) {
  constexpr double kC1 = (0.01 * kPeak) * (0.01 * kPeak), kC2 = (0.03 * kPeak) * (0.03 * kPeak);
  const double a = m[0], b = m[1];
  const double var_a = std::max(0.0, m[2] - a * a), var_b = std::max(0.0, m[3] - b * b), cov = m[4] - a * b;
  const double mean_a = a + kOffset, mean_b = b + kOffset;
  return (2 * mean_a * mean_b + kC1) * (2 * cov + kC2) /
         ((mean_a * mean_a + mean_b * mean_b + kC1) * (var_a + var_b + kC2));
}

/// Filters one channel of both images row by row; the last rows stay in a ring buffer for the vertical pass.
class SsimRows {
 public:
  SsimRows(const ImageU8& a, const ImageU8& b, int channel)
      : a_(a),
        b_(b),
        channel_(channel),
        norm_x_(window_normalisation(window_, a.width())),
        norm_y_(window_normalisation(window_, a.height())),
        padded_(a.width() + 2 * kRadius),
        ring_(std::size_t(kRing) * kMoments * a.width()),
        sums_(std::size_t(kMoments) * a.width()) {}

  /// Rows must be asked for from top to bottom; `row(y)[m * width + x]` is moment m at (x, y).
  const float* row(int y) {
    next_ = std::max(next_, y - kRadius);
    for (; next_ <= std::min(y + kRadius, a_.height() - 1); ++next_) filter_row(next_);
    const std::size_t size = sums_.size();
    std::fill(sums_.begin(), sums_.end(), 0.f);
    for (int i = std::max(-kRadius, -y); i <= std::min(kRadius, a_.height() - 1 - y); ++i) {
      const float weight = window_[i + kRadius] * norm_y_[y];
      const float* from = ring_row(y + i);
      for (std::size_t k = 0; k < size; ++k) sums_[k] += weight * from[k];
    }
    return sums_.data();
  }

 private:
  static constexpr int kRing = 2 * kRadius + 1;
  float* ring_row(int y) { return ring_.data() + std::size_t(y % kRing) * sums_.size(); }

  void filter_row(int y) {
    const int width = a_.width(), channels = a_.channels();
    const std::uint8_t *row_a = a_.row(y) + channel_, *row_b = b_.row(y) + channel_;
    for (int m = 0; m < kMoments; ++m) {
      float* padded = padded_.data() + kRadius;  // zeros on both sides: what is outside has no weight
      for (int x = 0; x < width; ++x) {
        const float va = float(row_a[x * channels]) - kOffset, vb = float(row_b[x * channels]) - kOffset;
        padded[x] = m == 0 ? va : m == 1 ? vb : m == 2 ? va * va : m == 3 ? vb * vb : va * vb;
      }
      float* out = ring_row(y) + std::size_t(m) * width;
      std::fill(out, out + width, 0.f);
      for (int i = 0; i < kRing; ++i)
        for (int x = 0; x < width; ++x) out[x] += window_[i] * padded_[x + i];
      for (int x = 0; x < width; ++x) out[x] *= norm_x_[x];
    }
  }

  const ImageU8 &a_, &b_;
  int channel_;
  std::array<float, kRing> window_ = gaussian_window();
  std::vector<float> norm_x_, norm_y_, padded_, ring_, sums_;
  int next_ = 0;
};

}  // namespace

double SquaredError::psnr_db() const {
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  if (sum == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(kPeak * kPeak * static_cast<double>(count) / sum);
}

SquaredError squared_error(const ImageU8& a, const ImageU8& b, const ImageU8& mask) {
  check_comparable(a, b, mask);
  SquaredError error;
  const int channels = a.channels();
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      if (!mask.empty() && mask.at(x, y) == 0) continue;
      const std::uint8_t *pa = a.pixel(x, y), *pb = b.pixel(x, y);
      for (int c = 0; c < channels; ++c) {
        const int difference = int(pa[c]) - int(pb[c]);
        error.sum += difference * difference;
      }
      error.count += channels;
    }
  return error;
}

double ssim(const ImageU8& a, const ImageU8& b, const ImageU8& mask) {
  check_comparable(a, b, mask);
  double sum = 0;
  std::size_t count = 0;
  for (int c = 0; c < a.channels(); ++c) {
    SsimRows rows(a, b, c);
    for (int y = 0; y < a.height(); ++y) {
      const auto counts = [&](int x) { return mask.empty() || mask.at(x, y) != 0; };
      int first = 0;
      while (first < a.width() && !counts(first)) ++first;
      if (first == a.width()) continue;
      const float* moments = rows.row(y);
      for (int x = first; x < a.width(); ++x) {
        if (!counts(x)) continue;
        std::array<float, kMoments> m;
        for (int k = 0; k < kMoments; ++k) m[k] = moments[std::size_t(k) * a.width() + x];
        sum += pixel_ssim(m);
        ++count;
      }
    }
  }
  return count ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

ImageU8 erode(const ImageU8& mask, int radius) {
  if (mask.empty() || radius < 1) return mask;
  const int width = mask.width(), height = mask.height();
  ImageU8 rows = mask, out = mask;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      rows.at(x, y) =
          *std::min_element(mask.pixel(std::max(0, x - radius), y), mask.pixel(std::min(width - 1, x + radius), y) + 1);
  out = rows;
  for (int y = 0; y < height; ++y)
    for (int other = std::max(0, y - radius); other <= std::min(height - 1, y + radius); ++other)
      for (int x = 0; x < width; ++x) out.at(x, y) = std::min(out.at(x, y), rows.at(x, other));
  return out;
}

}  // namespace sheen
