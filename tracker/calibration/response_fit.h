// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "tracker/calibration/cell_image.h"
#include "tracker/calibration/response.h"

namespace sheen {

/// How one model explains a sweep.
struct ResponseComparison {
  ResponseModel model = ResponseModel::kLinear;
  int unknowns = 0;
  double rms_levels = 0;              ///< of cells' values, in steps of 1/255
  double cross_validated_levels = 0;  ///< of cells that the model was not estimated from
};

/// What a camera makes of light, by images of a scene that does not change at several exposures.
struct ResponseFit {
  Response response;
  Eigen::MatrixXd covariance;  ///< of the response's numbers
  std::vector<ResponseComparison> models;
  std::vector<double> exposure_error;      ///< by which an image got more light than its exposure says, as a part of it
  double exposure_sigma = 0;               ///< how well exposures are kept: standard deviation of these
  double noise_factor = 1;                 ///< residuals over what the pixels' noise explains
  double rms_levels = 0;                   ///< of cells' values, in steps of 1/255
  int cells_used = 0, cells_rejected = 0;  ///< of each channel apart; rejected: they do not follow the others
  double lowest = 0, highest = 1;          ///< values that were used, of full scale
  double saturation = 1;                   ///< value at which cells stop following the light, of full scale
  bool saturation_seen = false;
  /// Mean of the dark frames, where there are any, and of what the sweep alone says of the value without light.
  double dark_value = 0, dark_uncertainty = 0;
  double intercept = 0, intercept_uncertainty = 0;
  bool has_dark = false;

  double black_level() const { return response.black_level(); }
  double black_level_uncertainty() const;
  double gamma_uncertainty() const;  ///< 0 where the model has no gamma
  /// Standard deviation of light(value) / light(highest).
  double relative_uncertainty(double value) const;
  /// Greatest distance of the values used from the straight line that fits them best, over the range.
  double nonlinearity() const;
};

/// Estimates the response and each cell's light together, least squares weighted by the noise that the pixels show:
/// Debevec and Malik 1997 with a smooth curve in place of one number for each value, on means of cells, whose error is
/// known. Exposures may err by what the images themselves show. Of the models the simplest wins that is not worse than
/// the best on cells it was not estimated from. `exposures`: of each image, any unit. Throws Error that says which
/// images are missing.
ResponseFit fit_response(std::span<const CellImage> sweep, std::span<const double> exposures,
                         std::span<const CellImage> dark);

}  // namespace sheen
