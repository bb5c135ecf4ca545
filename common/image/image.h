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

  /// Another size; the storage is kept where it will do, what the pixels hold is unspecified.
  void resize(int width, int height, int channels) {
    width_ = width;
    height_ = height;
    channels_ = channels;
    const std::size_t size = std::size_t(width) * height * channels;
    if (size > data_.capacity()) data_ = {};  // or it would grow to twice of what it was, and both be there at once
    data_.resize(size);
  }

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

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool operator==(const PixelBox&) const = default;
};

using ImageU8 = Image<std::uint8_t>;
using ImageF = Image<float>;

struct ImageSize {
  int width = 0;
  int height = 0;
};

}  // namespace sheen
