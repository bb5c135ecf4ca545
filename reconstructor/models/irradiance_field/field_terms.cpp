// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/field_terms.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheen {
namespace {

using TileMatrix = Eigen::Matrix<float, kTileSide, kTileSide, Eigen::RowMajor>;

/// Orthonormal DCT-II: row u is the cosine of frequency u.
const TileMatrix& cosines() {
  static const TileMatrix matrix = [] {
    TileMatrix m;
    for (int u = 0; u < kTileSide; ++u)
      for (int x = 0; x < kTileSide; ++x)
        m(u, x) = static_cast<float>(std::sqrt((u == 0 ? 1.0 : 2.0) / kTileSide) *
                                     std::cos(std::numbers::pi * (x + 0.5) * u / kTileSide));
    return m;
  }();
  return matrix;
}

const std::array<std::array<int, 2>, kTilePixels>& frequencies() {
  static const auto order = [] {
    std::array<std::array<int, 2>, kTilePixels> list{};
    std::size_t k = 0;
    for (int sum = 0; sum <= 2 * (kTileSide - 1); ++sum)
      for (int x = std::max(0, sum - kTileSide + 1); x <= std::min(sum, kTileSide - 1); ++x) list[k++] = {x, sum - x};
    return list;
  }();
  return order;
}

/// One colour component of an image as the frequencies of its tiles.
Eigen::VectorXf tile_spectrum(const ImageF& image, const Eigen::RowVector3f& component) {
  const TileGrid grid = tile_grid({image.width(), image.height()});
  Eigen::VectorXf spectrum(static_cast<Eigen::Index>(grid.tiles()) * kTilePixels);
  TileMatrix tile;
  for (std::size_t t = 0; t < grid.tiles(); ++t) {
    const int left = kTileSide * static_cast<int>(t % static_cast<std::size_t>(grid.across)),
              top = kTileSide * static_cast<int>(t / static_cast<std::size_t>(grid.across));
    for (int y = 0; y < kTileSide; ++y)
      for (int x = 0; x < kTileSide; ++x)
        tile(y, x) = component.dot(Eigen::Map<const Eigen::RowVector3f>(
            image.pixel(std::min(left + x, image.width() - 1), std::min(top + y, image.height() - 1))));
    const TileMatrix transformed = cosines() * tile * cosines().transpose();
    float* out = spectrum.data() + t * kTilePixels;
    for (const auto& [u, v] : frequencies()) *out++ = transformed(v, u);
  }
  return spectrum;
}

}  // namespace

TileGrid tile_grid(const ImageSize& size) {
  return {(size.width + kTileSide - 1) / kTileSide, (size.height + kTileSide - 1) / kTileSide};
}

std::array<int, 2> tile_frequency(int k) {
  return frequencies()[static_cast<std::size_t>(k)];
}

Eigen::Matrix3f component_of_colour() {
  Eigen::Matrix3d m;
  m << 1, 1, 1, 1, 0, -1, 1, -2, 1;
  m.rowwise().normalize();
  return m.cast<float>();
}

FieldTerms find_terms(std::span<const ImageF> images, double least_rms, Eigen::MatrixXd& gram) {
  FieldTerms field{.size = {images.front().width(), images.front().height()}};
  const auto n = static_cast<Eigen::Index>(images.size()),
             rows = static_cast<Eigen::Index>(tile_grid(field.size).tiles()) * kTilePixels;
  gram = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t c = 0; c < field.components.size(); ++c) {
    Eigen::MatrixXf spectra(rows, n);
    const Eigen::RowVector3f component = component_of_colour().row(static_cast<Eigen::Index>(c));
    tbb::parallel_for(Eigen::Index{0}, n, [&](Eigen::Index i) {
      spectra.col(i) = tile_spectrum(images[static_cast<std::size_t>(i)], component);
    });
    Eigen::MatrixXd own = Eigen::MatrixXd::Zero(n, n);
    constexpr Eigen::Index kBlock = 4096;  // sums in single precision no longer than this
    for (Eigen::Index at = 0; at < rows; at += kBlock) {
      const auto block = spectra.middleRows(at, std::min(kBlock, rows - at));
      own += (block.transpose() * block).cast<double>();
    }
    gram += own;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(own);
    const double least = least_rms * least_rms * static_cast<double>(rows);
    Eigen::Index terms = 0;
    while (terms < n && eigen.eigenvalues()[n - 1 - terms] > least) ++terms;
    field.components[c].basis = eigen.eigenvectors().rightCols(terms).rowwise().reverse().cast<float>();
    field.components[c].coefs = spectra * field.components[c].basis;
  }
  return field;
}

void tile_from_frequencies(const float* frequency, float* pixels) {
  TileMatrix transformed;
  for (const auto& [u, v] : frequencies()) transformed(v, u) = *frequency++;
  Eigen::Map<TileMatrix>(pixels, kTileSide, kTileSide) = cosines().transpose() * transformed * cosines();
}

}  // namespace sheen
