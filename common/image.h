// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheen {

/// Interleaved image, row by row without padding: `at(x, y, c)`.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, T value = T{})
      : width_(width), height_(height), channels_(channels), data_(std::size_t(width) * height * channels, value) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return data_.empty(); }
  std::size_t size() const { return data_.size(); }

  T* data() { return data_.data(); }
  const T* data() const { return data_.data(); }
  T* row(int y) { return data_.data() + std::size_t(y) * width_ * channels_; }
  const T* row(int y) const { return data_.data() + std::size_t(y) * width_ * channels_; }
  T* pixel(int x, int y) { return row(y) + std::size_t(x) * channels_; }
  const T* pixel(int x, int y) const { return row(y) + std::size_t(x) * channels_; }
  T& at(int x, int y, int c = 0) {
    assert(x >= 0 && x < width_ && y >= 0 && y < height_ && c >= 0 && c < channels_);
    return pixel(x, y)[c];
  }
  const T& at(int x, int y, int c = 0) const {
    assert(x >= 0 && x < width_ && y >= 0 && y < height_ && c >= 0 && c < channels_);
    return pixel(x, y)[c];
  }
  bool operator==(const Image&) const = default;

 private:
  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> data_;
};

using ImageU8 = Image<std::uint8_t>;
using ImageF = Image<float>;

}  // namespace sheen
