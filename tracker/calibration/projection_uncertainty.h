// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/camera/camera.h"
#include "tracker/calibration/bundle.h"

namespace sheen {

/// A value (pixels) at each point of a grid that spans the image, row by row from the top left pixel to the bottom
/// right one; NaN where the lens has no ray.
struct ImageMap {
  int width = 0, height = 0;  ///< of the image
  int columns = 0, rows = 0;
  std::vector<double> values;

  Eigen::Vector2d pixel(int column, int row) const;
  double at(int column, int row) const { return values[static_cast<std::size_t>(row * columns + column)]; }
  double centre() const { return at(columns / 2, rows / 2); }
  double rms() const;    ///< of what is finite
  double worst() const;  ///< likewise
  Eigen::Vector2d worst_pixel() const;
  int missing() const;  ///< how many are NaN
};

using IntrinsicsCovariance = Eigen::Matrix<double, kIntrinsics, kIntrinsics>;

/// Covariance (px^2) of the pixel at which a distant point appears, for each point of the map's grid. What a small
/// rotation of the camera undoes is no error of its projection (a pose is solved in every image anyway): the rotation
/// that fits best within half the image's height of its middle is taken out.
std::vector<Eigen::Matrix2d> projection_covariance(const Camera& camera, const IntrinsicsCovariance& covariance);

/// Expected length (RMS) of a pixel's error: the square root of that covariance's trace.
ImageMap projection_uncertainty(const Camera& camera, const IntrinsicsCovariance& covariance);

/// How far apart two cameras put the same distant point, after the rotation between them that fits best (as above).
/// The vectors (pixels of `camera`'s grid; NaN where one has no ray), and their lengths.
std::vector<Eigen::Vector2d> projection_shift(const Camera& camera, const Camera& other);
ImageMap projection_difference(const Camera& camera, const Camera& other);

}  // namespace sheen
