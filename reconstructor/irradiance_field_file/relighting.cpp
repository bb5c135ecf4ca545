// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/relighting.h"

#include <algorithm>
#include <cmath>

#include "common/image/color.h"

namespace sheen {
namespace {

using TilePixels = Eigen::Matrix<float, kTilePixels, 1>;
using TileNumbers = Eigen::Matrix<std::int16_t, kTilePixels, 1>;

constexpr int kTableSteps = 16;  // per grey level: linear interpolation is off by less than 1e-7

const std::vector<float>& decoding_table() {
  static const std::vector<float> table = [] {
    std::vector<float> values;
    for (int i = 0; i <= 255 * kTableSteps + 1; ++i)
      values.push_back(srgb_decode(static_cast<float>(i) / (255.0f * kTableSteps)));
    return values;
  }();
  return table;
}

float decoded(float level, const std::vector<float>& table) {
  if (!(level > 0)) return 0;
  if (level >= 255) return srgb_decode(level / 255);
  const float at = level * kTableSteps;
  const auto i = static_cast<std::size_t>(at);
  return table[i] + (at - static_cast<float>(i)) * (table[i + 1] - table[i]);
}

}  // namespace

Relighting::Relighting(const FieldTerms& field, const ForEach& for_each)
    : size_(field.size), tiles_(tile_grid(field.size).tiles()) {
  for (std::size_t c = 0; c < basis_.size(); ++c) basis_[c] = field.components[c].basis;
  for_each(tiles_.size(), [&](std::size_t i) {
    Tile& tile = tiles_[i];
    const auto first = static_cast<Eigen::Index>(i) * kTilePixels;
    for (std::size_t c = 0; c < basis_.size(); ++c)
      for (Eigen::Index t = 0; t < basis_[c].cols(); ++t)
        if (!field.components[c].coefs.col(t).segment<kTilePixels>(first).isZero(0))
          tile.terms[c].push_back(static_cast<std::uint16_t>(t));
    for (std::size_t c = 0; c < basis_.size(); ++c)
      for (const std::uint16_t t : tile.terms[c]) {
        TilePixels pixels;
        tile_from_frequencies(field.components[c].coefs.col(t).data() + first, pixels.data());
        constexpr float kLargest = 32767;
        const float scale = pixels.cwiseAbs().maxCoeff() / kLargest;
        tile.scales.push_back(scale);
        for (const float pixel : pixels)
          tile.pixels.push_back(scale > 0 ? static_cast<std::int16_t>(std::lround(pixel / scale)) : std::int16_t{0});
      }
  });
}

ImageF Relighting::encoded_picture(const Eigen::VectorXf& weights, const ForEach& for_each) const {
  std::array<Eigen::VectorXf, 3> amounts;
  for (std::size_t c = 0; c < basis_.size(); ++c) amounts[c] = basis_[c].transpose() * weights;
  const Eigen::Matrix3f colour_of_component = component_of_colour().transpose();
  const auto across = static_cast<std::size_t>(tile_grid(size_).across);
  ImageF picture(size_.width, size_.height, 3);
  for_each(tiles_.size(), [&](std::size_t i) {
    const Tile& tile = tiles_[i];
    Eigen::Matrix<float, kTilePixels, 3> sums = Eigen::Matrix<float, kTilePixels, 3>::Zero();
    const std::int16_t* pixels = tile.pixels.data();
    const float* scale = tile.scales.data();
    for (std::size_t c = 0; c < amounts.size(); ++c)
      for (const std::uint16_t t : tile.terms[c]) {
        sums.col(static_cast<Eigen::Index>(c)) +=
            *scale++ * amounts[c][t] * Eigen::Map<const TileNumbers>(pixels).cast<float>();
        pixels += kTilePixels;
      }
    const int left = kTileSide * static_cast<int>(i % across), top = kTileSide * static_cast<int>(i / across);
    for (int y = 0; y < std::min(kTileSide, size_.height - top); ++y)
      for (int x = 0; x < std::min(kTileSide, size_.width - left); ++x)
        Eigen::Map<Eigen::Vector3f>(picture.pixel(left + x, top + y)) =
            colour_of_component * sums.row(y * kTileSide + x).transpose();
  });
  return picture;
}

std::vector<std::size_t> Relighting::ranks() const {
  std::vector<std::size_t> ranks;
  for (const Tile& tile : tiles_) ranks.push_back(tile.scales.size());
  return ranks;
}

std::size_t Relighting::bytes() const {
  std::size_t bytes = 0;
  for (const Tile& tile : tiles_) bytes += tile.pixels.size() * sizeof(std::int16_t);
  return bytes;
}

ImageU8 rounded_levels(const ImageF& picture, const ForEach& for_each) {
  ImageU8 rounded(picture.width(), picture.height(), picture.channels());
  for_each(static_cast<std::size_t>(picture.height()), [&](std::size_t y) {
    const float* row = picture.row(static_cast<int>(y));
    std::transform(row, row + std::ptrdiff_t{picture.width()} * picture.channels(), rounded.row(static_cast<int>(y)),
                   [](float level) { return static_cast<std::uint8_t>(std::clamp(level, 0.0f, 255.0f) + 0.5f); });
  });
  return rounded;
}

void decode_levels(ImageF& picture, const ForEach& for_each) {
  const std::vector<float>& table = decoding_table();
  for_each(static_cast<std::size_t>(picture.height()), [&](std::size_t y) {
    float* row = picture.row(static_cast<int>(y));
    std::transform(row, row + std::ptrdiff_t{picture.width()} * picture.channels(), row,
                   [&](float level) { return decoded(level, table); });
  });
}

}  // namespace sheen
