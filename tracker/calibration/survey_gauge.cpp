// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/survey_gauge.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"

namespace sheen {

Eigen::Vector3d middle_of_tag(const Eigen::Vector3d* corners) {
  return (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
}

Similarity robust_similarity(std::span<const Eigen::Vector3d> sheet, std::span<const Eigen::Vector3d> found,
                             std::vector<double>& weights) {
  constexpr int kIterations = 30;
  constexpr double kNear_m = 2e-4;  // what a printer and flat paper do: weighted alike
  weights.assign(sheet.size(), 1);
  Similarity fit;
  for (int i = 0; i < kIterations; ++i) {
    fit = fit_similarity(sheet, found, weights);
    for (std::size_t tag = 0; tag < sheet.size() / 4; ++tag) {
      double farthest = kNear_m;
      for (std::size_t c = 4 * tag; c < 4 * tag + 4; ++c)
        farthest = std::max(farthest, (fit * sheet[c] - found[c]).norm());
      for (std::size_t c = 4 * tag; c < 4 * tag + 4; ++c) weights[c] = std::pow(kNear_m / farthest, 2);
    }
  }
  return fit;
}

Eigen::MatrixXd gauge(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> sheet,
                      std::span<const double> weights, int from_tag, int to_tag) {
  const int count = static_cast<int>(points.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(7, 3 * count);
  double total = 0, spread = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < count; ++i) {
    total += weights[i];
    mean += weights[i] * sheet[i];
  }
  mean /= total;
  for (int i = 0; i < count; ++i) spread += weights[i] * (sheet[i] - mean).squaredNorm();
  const Eigen::Vector3d along =
      (middle_of_tag(&points[4 * to_tag]) - middle_of_tag(&points[4 * from_tag])).normalized();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d arm = sheet[i] - mean;
    Eigen::Matrix3d cross;
    cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    // mean(points) = scale * mean(sheet), and the scale is the points' own.
    rows.block<3, 3>(0, 3 * i) = weights[i] * (Eigen::Matrix3d::Identity() / total - mean * arm.transpose() / spread);
    rows.block<3, 3>(3, 3 * i) = weights[i] * cross;
    const double end = (i / 4 == to_tag ? 0.25 : 0) - (i / 4 == from_tag ? 0.25 : 0);
    rows.block<1, 3>(6, 3 * i) = end * along.transpose();
  }
  return rows;
}

Eigen::MatrixXd constrained_inverse(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& gauge, int first) {
  const int size = static_cast<int>(normal.rows()), rows = static_cast<int>(gauge.rows());
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) throw Error("the images do not determine the stage");
  Eigen::MatrixXd bordered = Eigen::MatrixXd::Zero(size + rows, size + rows);
  bordered.topLeftCorner(size, size) = scale.asDiagonal() * normal * scale.asDiagonal();
  for (int row = 0; row < rows; ++row) {
    Eigen::VectorXd line = Eigen::VectorXd::Zero(size);
    line.segment(first, gauge.cols()) = gauge.row(row).transpose();
    line = scale.cwiseProduct(line);
    bordered.block(size + row, 0, 1, size) = line.normalized().transpose();
    bordered.block(0, size + row, size, 1) = line.normalized();
  }
  const Eigen::MatrixXd inverse = bordered.partialPivLu().inverse();
  return scale.asDiagonal() * inverse.topLeftCorner(size, size) * scale.asDiagonal();
}

}  // namespace sheen
