// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/image/linear_reader.h"
#include "tracker/fiducials/tag_detector.h"

namespace sheen {
namespace {

constexpr int kSaturated = 250;
constexpr int kQuadStep = 8;     ///< every 4th quad each way is enough for a median
constexpr int kMinQuads = 100;   ///< fewer bright quads than this say nothing about colour
constexpr double kBright = 0.5;  ///< of the 95th percentile of green
constexpr double kMaxGain = 8;
constexpr std::uint32_t kGainOne = 1 << 12;

using Quad = std::array<std::uint8_t, 4>;  ///< sites (0,0) (1,0) (0,1) (1,1)

/// Green stands at (1,0) and (0,1) of RG and BG mosaics, at (0,0) and (1,1) of GR and GB.
std::array<int, 2> green_sites(PixelFormat format) {
  const bool off_diagonal = format == PixelFormat::kBayerRG8 || format == PixelFormat::kBayerBG8;
  return off_diagonal ? std::array{1, 2} : std::array{0, 3};
}

std::vector<Quad> sample_quads(const ImageU8& mosaic) {
  std::vector<Quad> quads;
  for (int y = 0; y + 1 < mosaic.height(); y += kQuadStep)
    for (int x = 0; x + 1 < mosaic.width(); x += kQuadStep)
      quads.push_back({mosaic.at(x, y), mosaic.at(x + 1, y), mosaic.at(x, y + 1), mosaic.at(x + 1, y + 1)});
  return quads;
}

std::array<double, 4> site_gains(const ImageU8& mosaic, PixelFormat format) {
  const auto [green_a, green_b] = green_sites(format);
  const auto green = [a = green_a, b = green_b](const Quad& q) { return (q[a] + q[b]) / 2.0; };
  std::vector<Quad> quads = sample_quads(mosaic);
  std::erase_if(quads, [](const Quad& q) { return std::ranges::max(q) >= kSaturated; });
  std::array<double, 4> gains{1, 1, 1, 1};
  if (quads.size() < kMinQuads) return gains;
  const auto p95 = quads.begin() + quads.size() * 95 / 100;
  std::ranges::nth_element(quads, p95, {}, green);
  const double bright = std::max(kBright * green(*p95), 1.0);
  std::erase_if(quads, [&](const Quad& q) { return green(q) < bright || std::ranges::min(q) < 1; });
  if (quads.size() < kMinQuads) return gains;
  std::vector<double> ratios(quads.size());
  for (int site = 0; site < 4; ++site) {
    std::ranges::transform(quads, ratios.begin(), [&](const Quad& q) { return green(q) / q[site]; });
    gains[site] = std::clamp(median(ratios), 1 / kMaxGain, kMaxGain);
  }
  return gains;
}

}  // namespace

ImageU8 detection_image(const RawImage& image) {
  ImageU8 grey = to_grey8(image);
  if (!is_bayer(image.format)) return grey;
  const std::array<double, 4> gains = site_gains(grey, image.format);
  // A multiplication per pixel, not a table: registers hold many of them.
  std::vector<std::uint32_t> row_gains(static_cast<std::size_t>(grey.width()));
  for (int parity = 0; parity < 2; ++parity) {
    for (std::size_t x = 0; x < row_gains.size(); ++x)
      row_gains[x] = static_cast<std::uint32_t>(gains[2 * parity + x % 2] * kGainOne + 0.5);
    for (int y = parity; y < grey.height(); y += 2) {
      std::uint8_t* row = grey.row(y);
      for (std::size_t x = 0; x < row_gains.size(); ++x)
        row[x] = static_cast<std::uint8_t>(std::min(255u, (row[x] * row_gains[x] + kGainOne / 2) / kGainOne));
    }
  }
  return grey;
}

}  // namespace sheen
