// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/edge_fill.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

namespace sheen {
namespace {

constexpr int kMargin = 1;  // of the marks round the image, so that every pixel has eight neighbours

template <typename F>  // f(y)
void for_each_row(int rows, F&& f) {
  tbb::parallel_for(tbb::blocked_range<int>(0, rows, 16), [&](const tbb::blocked_range<int>& range) {
    for (int y = range.begin(); y < range.end(); ++y) f(y);
  });
}

/// `marks` have a pixel of margin. `touches`: not 0 where one of the eight neighbours is marked; vectorised, since most
/// pixels are far from all edges.
void touching(const ImageU8& marks, int y, std::vector<std::uint8_t>& touches) {
  const std::uint8_t *above = marks.row(y), *row = marks.row(y + 1), *below = marks.row(y + 2);
  for (std::size_t x = 0; x < touches.size(); ++x)
    touches[x] = above[x] | above[x + 1] | above[x + 2] | row[x] | row[x + 2] | below[x] | below[x + 1] | below[x + 2];
}

void take_mean_of_neighbours(const ImageU8& marks, int x, int y, ImageF& pixels) {
  float* out = pixels.pixel(x, y);
  for (int c = 0; c < pixels.channels(); ++c) {
    float sum = 0;
    int count = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        if ((i != 0 || j != 0) && marks.at(x + i + kMargin, y + j + kMargin)) {
          sum += pixels.at(x + i, y + j, c);
          ++count;
        }
    out[c] = sum / static_cast<float>(count);
  }
}

}  // namespace

void fill_edges(const ImageU8& from_edge, int left, int top, ImageF& pixels) {
  const int w = pixels.width(), h = pixels.height();
  assert(left >= 0 && top >= 0 && left + w <= from_edge.width() && top + h <= from_edge.height());
  ImageU8 marks(w + 2 * kMargin, h + 2 * kMargin, 1);
  for_each_row(h, [&](int y) { std::copy_n(from_edge.row(top + y) + left, w, marks.row(y + kMargin) + kMargin); });
  // Marked pixels are read only and others written only, so that the outcome does not depend on which rows come first.
  for_each_row(h, [&](int y) {
    std::vector<std::uint8_t> touches(static_cast<std::size_t>(w));
    touching(marks, y, touches);
    const std::uint8_t* own = marks.row(y + kMargin) + kMargin;
    for (int x = 0; x < w; ++x)
      if (!own[x] && touches[x]) take_mean_of_neighbours(marks, x, y, pixels);
  });
}

}  // namespace sheen
