// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <functional>
#include <vector>

#include "reconstructor/splats/splat_painter.h"

namespace sheen {

/// A picture that splats are to show.
struct SplatView {
  SplatShares shares;                 ///< of `splats`, by their index there
  std::vector<std::uint32_t> splats;  ///< that are seen
  Eigen::MatrixXf harmonics;          ///< terms x these
  Eigen::Matrix3Xf wanted;            ///< per pixel: encoded, less 0.5, as far as splats cover it
  float weight = 1;                   ///< of a pixel
};

/// `encoded`: 3 channels, of the camera's size. `pixels`: 1 channel, 0 where nothing is wanted.
SplatView splat_view(const std::vector<SplatShape>& shapes, int terms, const PosedCamera& from, const ImageF& encoded,
                     const ImageU8& pixels);

/// The least squares of the differences between what splats show and what they are to show, over all of their colours
/// at once. A splat is held, by little, where it is, and the less it varies with the view the better.
class ColourFit {
 public:
  static constexpr int kRounds = 20;  ///< of conjugate gradients

  ColourFit(std::vector<SplatView> views, std::size_t splats, int terms);

  /// `colours`: as `Splats::colours`. The same on any number of processors.
  void improve(Eigen::MatrixXf& colours, const std::function<void()>& round_done) const;

 private:
  template <typename Add>
  Eigen::MatrixXf sum_over_views(const Eigen::MatrixXf& like, const Add& add) const;
  Eigen::MatrixXf solved_alone(Eigen::MatrixXf residual) const;

  std::vector<SplatView> views_;
  int terms_;
  Eigen::VectorXf held_;                             ///< per row of the colours, pixels
  std::vector<Eigen::LLT<Eigen::MatrixXf>> blocks_;  ///< of each splat, as if it were alone
};

}  // namespace sheen
