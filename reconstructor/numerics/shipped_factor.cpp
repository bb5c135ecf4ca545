// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/shipped_factor.h"

namespace sheen {

OnlineSvdOptions shipped_factor(OnlineSvdOptions options) {
  options.channels = 3;
  options.sensor_variance = kCameraVariance;
  return options;
}

double orthogonality_lost(const OnlineSvd& factor) {
  if (factor.rank() == 0) return 0;
  const Eigen::MatrixXd b = factor.orthonormal_basis().cast<double>();
  return (b.transpose() * b - Eigen::MatrixXd::Identity(factor.rank(), factor.rank())).cwiseAbs().maxCoeff();
}

}  // namespace sheen
