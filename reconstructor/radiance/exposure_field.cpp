// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/exposure_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sheen {

float ExposureField::at(const Eigen::Vector3d& eye) const {
  if (directions.cols() == 0) return 1;
  return std::exp(interpolate(log_gain, directions, kernel, (eye.cast<float>() - centre).normalized())[0]);
}

ExposureField interpolated_exposure(const Eigen::Vector3f& centre, std::span<const Eigen::Vector3d> eyes,
                                    std::span<const float> log_gains) {
  ExposureField field;
  if (std::all_of(log_gains.begin(), log_gains.end(), [](float gain) { return gain == 0; })) return field;
  const auto n = static_cast<Eigen::Index>(eyes.size());
  field.centre = centre;
  field.directions.resize(3, n);
  for (Eigen::Index j = 0; j < n; ++j) field.directions.col(j) = (eyes[j].cast<float>() - centre).normalized();
  const Eigen::Map<const Eigen::RowVectorXf> gains(log_gains.data(), n);
  double lowest = std::numeric_limits<double>::infinity();
  for (const ViewKernel& kernel : kViewKernels) {
    ViewInterpolant candidate = krige(field.directions, gains, Eigen::VectorXf::Ones(n), kernel);
    if (candidate.leave_one_out >= lowest) continue;
    lowest = candidate.leave_one_out;
    field.log_gain = std::move(candidate);
    field.kernel = kernel;
  }
  return field;
}

}  // namespace sheen
