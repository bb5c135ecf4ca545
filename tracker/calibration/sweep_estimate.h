// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tracker/calibration/response.h"

namespace sheen {

/// A cell of a channel in one image of a sweep.
struct SweepRow {
  int image = 0;
  double value = 0, pixel_variance = 0, variance = 0;  ///< of the mean
};
/// A cell of a channel: what it showed at several exposures of one amount of light.
using SweepTrack = std::vector<SweepRow>;

/// What dark frames say of the value without light, of full scale.
struct DarkLevel {
  double value = 0, sigma = 0, pixel_variance = 0;
};

/// All that is known of a sweep.
struct SweepProblem {
  std::vector<SweepTrack> tracks;
  std::vector<double> exposures;
  std::optional<DarkLevel> dark;
};

/// A finished estimate of one model.
struct SweepEstimate {
  Response response;
  Eigen::MatrixXd covariance;          ///< of the numbers of the response
  std::vector<double> exposure_error;  ///< of each image, as a part of its exposure
  double exposure_sigma = 0;           ///< how well exposures are kept: standard deviation of `exposure_error`
  double noise_factor = 1;             ///< residuals over what the noise of the pixels explains
};

/// First as if exposures were exact: free from the beginning they would take up what a wrong response leaves. Then
/// their errors are as large as the images themselves say (MacKay 1992): their squares over the number of them that
/// the images determine. Throws Error.
SweepEstimate estimate(const SweepProblem& problem, const Response& start);

/// Mean squared residual of each track: in levels of 1/255, or `weighted` by what is known of the noise.
std::vector<double> track_errors(const std::vector<SweepTrack>& tracks, const SweepProblem& problem,
                                 const SweepEstimate& fit, bool weighted);

/// The value without light and without noise: the mean of dark frames is lower where the response is bent over their
/// noise. What of that is more than the second order is not known.
DarkLevel without_bend(DarkLevel dark, const Response& response);

}  // namespace sheen
