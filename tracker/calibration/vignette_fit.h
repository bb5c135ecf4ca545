// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "common/image/photometry.h"
#include "tracker/calibration/cell_image.h"
#include "tracker/calibration/response.h"

namespace sheen {

/// Where the target of a flat image is seen: what lies at pixel p of the first image, measured from the image's middle,
/// is seen at R(turn) p + shift in this one.
struct TargetMove {
  double turn_rad = 0;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
};

struct FlatImage {
  CellImage cells;
  TargetMove move;
};

/// What the light on the target is taken to be.
enum class TargetLight {
  kEven,     ///< the same everywhere, as in an integrating sphere
  kUnknown,  ///< anything smooth that moves with the target: told apart from the lens by the moves
};

struct VignetteFit {
  Vignette vignette;
  Eigen::Matrix<double, 5, 5> covariance;  ///< of k1 k2 k3 cx cy
  double corner = 1;                       ///< the lens's light in the darkest corner of the image
  double worst_uncertainty = 0;            ///< greatest over the image: standard deviation of the vignette, relative
  double centre_uncertainty_px = 0;
  double rms = 0;          ///< relative residual of a cell
  double left_radial = 0;  ///< greatest mean residual of a ring round the centre, relative
  double left_colour = 0;  ///< greatest mean of a ring by which a colour differs from the mean of all, relative
  std::vector<double> ring_radius, ring_residual;  ///< radius in half diagonals
  ImageSize size;
  int cells_used = 0, cells_unused = 0;  ///< unused: clipped, dark or with detail

  /// Whether lens and light are told apart: what is left open is small.
  bool determined() const;
  double uncertainty_at(double x, double y) const;  ///< relative
};

/// Least squares on the logarithm of each cell's light: log(image's gain) + log(light on the target) + log(vignette),
/// the light a polynomial of degree 6 in the target's own place where it is unknown. Radial light that does not move
/// cannot be told from a lens; the uncertainty then says so. Throws Error.
VignetteFit fit_vignette(std::span<const FlatImage> flats, const Response& response, double saturation,
                         TargetLight light);

}  // namespace sheen
