// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/find_terms.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace sheen {
namespace {

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
    const TileMatrix transformed = tile_cosines() * tile * tile_cosines().transpose();
    float* out = spectrum.data() + t * kTilePixels;
    for (int k = 0; k < kTilePixels; ++k) {
      const auto [u, v] = tile_frequency(k);
      *out++ = transformed(v, u);
    }
  }
  return spectrum;
}

}  // namespace

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

}  // namespace sheen
