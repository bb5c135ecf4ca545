// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/edge_fill.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>
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

/// `marks` with a pixel of margin: 1 or 0. `touches`: 1 where one of the eight neighbours is marked; vectorised, since
/// most pixels are far from all edges.
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

void fill_edges(const ImageF& safe_depth, int left, int top, ImageF& pixels) {
  const int w = pixels.width(), h = pixels.height();
  assert(left >= 0 && top >= 0 && left + w <= safe_depth.width() && top + h <= safe_depth.height());
  // One mark a ring of pixels round the safe ones: a pass reads the ring before it and writes its own only, so that the
  // outcome does not depend on which rows come first.
  std::array<ImageU8, kFilledPixels + 1> ring;
  for (ImageU8& marks : ring) marks = ImageU8(w + 2 * kMargin, h + 2 * kMargin, 1);
  for_each_row(h, [&](int y) {
    const float* depth = safe_depth.row(top + y) + left;
    std::uint8_t* out = ring[0].row(y + kMargin) + kMargin;
    for (int x = 0; x < w; ++x) out[x] = depth[x] > 0;
  });
  for (int pass = 1; pass <= kFilledPixels; ++pass)
    for_each_row(h, [&](int y) {
      std::vector<std::uint8_t> wanted(static_cast<std::size_t>(w));
      touching(ring[pass - 1], y, wanted);
      std::uint8_t* out = ring[pass].row(y + kMargin) + kMargin;
      for (int earlier = 0; earlier < pass; ++earlier) {
        const std::uint8_t* marks = ring[earlier].row(y + kMargin) + kMargin;
        for (int x = 0; x < w; ++x) wanted[x] &= ~marks[x];
      }
      for (int x = 0; x < w; ++x) {
        if (!wanted[x]) continue;
        out[x] = 1;
        take_mean_of_neighbours(ring[pass - 1], x, y, pixels);
      }
    });
}

}  // namespace sheen
