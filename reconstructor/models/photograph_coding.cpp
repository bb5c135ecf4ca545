// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/photograph_coding.h"

#include <tbb/parallel_for.h>

#include <numeric>
#include <string>

#include "common/image/webp.h"

namespace sheen {
namespace {

/// Sums of values and of their weights over 2x2 pixels (`weighted`: r w, g w, b w, w).
ImageF halved(const ImageF& weighted) {
  ImageF half((weighted.width() + 1) / 2, (weighted.height() + 1) / 2, 4);
  for (int y = 0; y < weighted.height(); ++y)
    for (int x = 0; x < weighted.width(); ++x)
      for (int c = 0; c < 4; ++c) half.at(x / 2, y / 2, c) += weighted.at(x, y, c);
  return half;
}

/// Pixels without weight take the mean of the least square round them that has some.
void fill_from_coarser(ImageF& weighted) {
  if (weighted.width() == 1 && weighted.height() == 1) return;
  ImageF coarser = halved(weighted);
  fill_from_coarser(coarser);
  for (int y = 0; y < weighted.height(); ++y)
    for (int x = 0; x < weighted.width(); ++x)
      if (weighted.at(x, y, 3) == 0)
        for (int c = 0; c < 4; ++c) weighted.at(x, y, c) = coarser.at(x / 2, y / 2, c);
}

/// Pixels that no colour is ever read from are continued from those beside them.
ImageU8 smooth_outside(const Photograph& photograph) {
  constexpr int kRead = 2;  // of the cubic kernel: pixels beyond the one that shows the object
  const ImageU8& pixels = photograph.pixels;
  const int w = pixels.width(), h = pixels.height();
  ImageF weighted(w, h, 4);
  const auto is_read = [&](int x, int y) {
    for (int j = std::max(0, y - kRead); j <= std::min(h - 1, y + kRead); ++j)
      for (int i = std::max(0, x - kRead); i <= std::min(w - 1, x + kRead); ++i)
        if (photograph.depth.at(i, j) > 0) return true;
    return false;
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      if (is_read(x, y)) {
        for (int c = 0; c < 3; ++c) weighted.at(x, y, c) = pixels.at(x, y, c);
        weighted.at(x, y, 3) = 1;
      }
  fill_from_coarser(weighted);
  ImageU8 smooth = pixels;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (int c = 0; c < 3; ++c)
        smooth.at(x, y, c) = static_cast<std::uint8_t>(weighted.at(x, y, c) / weighted.at(x, y, 3) + 0.5f);
  return smooth;
}

std::size_t total_size(const std::vector<std::string>& files) {
  return std::accumulate(files.begin(), files.end(), std::size_t{0},
                         [](std::size_t sum, const std::string& file) { return sum + file.size(); });
}

}  // namespace

void PhotographCoding::add(const Photograph& photograph) {
  pictures_.push_back(smooth_outside(photograph));
}

std::vector<std::string> PhotographCoding::coded(int quality) const {
  std::vector<std::string> files(pictures_.size());
  tbb::parallel_for(std::size_t{0}, pictures_.size(),
                    [&](std::size_t i) { files[i] = encode_webp(pictures_[i], static_cast<float>(quality)); });
  return files;
}

int PhotographCoding::quality_within(std::size_t bytes) const {
  int low = 0;
  for (int high = kBest; low < high;) {
    const int quality = (low + high + 1) / 2;
    if (total_size(coded(quality)) <= bytes)
      low = quality;
    else
      high = quality - 1;
  }
  return low;
}

CodedPhotographs code_photographs(const PhotographSet& photographs, std::size_t bytes) {
  PhotographCoding coding;
  for (const Photograph& photograph : photographs.photographs()) coding.add(photograph);
  const std::vector<std::string> files = coding.coded(coding.quality_within(bytes));
  std::vector<Photograph> decoded = photographs.photographs();
  for (std::size_t i = 0; i < decoded.size(); ++i) decoded[i].pixels = decode_webp(files[i]);
  return {std::make_shared<PhotographSet>(photographs, std::move(decoded)), total_size(files)};
}

}  // namespace sheen
