// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/edge_weights.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr int kRounds = 4;  ///< of (2) and (3): weights of the start are off by little
constexpr double kMinEdge_px = 1;
constexpr double kMinDeterminacy = 1e-14;  ///< of the information, smallest over largest pivot

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Row6 = Eigen::Matrix<double, 1, 6>;

/// One kind of error of all edges: residuals and their derivatives, per sqrt(length).
struct Errors {
  std::vector<Row6> jacobian;
  std::vector<double> residual;
  Matrix6 normal = Matrix6::Zero();    ///< A or B of (2)
  Vector6 gradient = Vector6::Zero();  ///< J^T r
  double variance = 1;                 ///< a or b of (1)
  double freedom = 0;

  void add(const Row6& j, double r) {
    jacobian.push_back(j);
    residual.push_back(r);
    normal += j.transpose() * j;
    gradient += j.transpose() * r;
  }
  /// (3)
  void estimate_variance(const Vector6& step, const Matrix6& covariance, double floor) {
    double sum = 0;
    for (std::size_t i = 0; i < residual.size(); ++i) sum += std::pow(residual[i] - jacobian[i].dot(step), 2);
    const double taken = (covariance * normal).trace() / variance;
    freedom = std::max(static_cast<double>(residual.size()) - taken, 1.0);
    variance = std::max(sum / freedom, floor);
  }
  double students_variance() const { return variance * freedom / std::max(freedom - 2, 1.0); }
};

struct EdgeErrors {
  Errors place, tilt;
};

/// Empty where a corner cannot be projected or an edge has no length.
std::optional<EdgeErrors> edge_errors(const Camera& camera, std::span<const Correspondence> points,
                                      const Rigid3& pose) {
  EdgeErrors errors;
  for (std::size_t tag = 0; tag + 4 <= points.size(); tag += 4)
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const Correspondence &a = points[tag + edge], &b = points[tag + (edge + 1) % 4];
      const auto at_a = project_with_jacobian(camera, pose, a.point_object);
      const auto at_b = project_with_jacobian(camera, pose, b.point_object);
      const Eigen::Vector2d along = b.pixel - a.pixel;
      const double length = along.norm();
      if (!at_a || !at_b || !(length >= kMinEdge_px)) return std::nullopt;
      const Eigen::RowVector2d across = Eigen::RowVector2d(along.y(), -along.x()) / length;
      const double r_a = across * (a.pixel - at_a->pixel), r_b = across * (b.pixel - at_b->pixel);
      const Row6 j_a = across * at_a->jacobian, j_b = across * at_b->jacobian;
      const double weight = std::sqrt(length) / 2;
      errors.place.add(weight * (j_a + j_b), weight * (r_a + r_b));
      errors.tilt.add(weight * (j_b - j_a), weight * (r_b - r_a));
    }
  return errors;
}

}  // namespace

std::optional<WeightedPose> weigh_edges(const Camera& camera, std::span<const Correspondence> points,
                                        const Rigid3& start, double noise_floor_px) {
  std::optional<EdgeErrors> errors = edge_errors(camera, points, start);
  if (!errors) return std::nullopt;
  auto& [place, tilt] = *errors;
  const auto inverse_of = [](const Matrix6& information) -> std::optional<Matrix6> {
    const Eigen::LDLT<Matrix6> ldlt(information);
    if (!(ldlt.rcond() >= kMinDeterminacy) || !ldlt.isPositive()) return std::nullopt;
    const Matrix6 inverse = ldlt.solve(Matrix6::Identity());
    return (inverse + inverse.transpose()) / 2;
  };
  const double floor = noise_floor_px * noise_floor_px;
  Vector6 step;
  for (int round = 0; round < kRounds; ++round) {
    const auto covariance = inverse_of(place.normal / place.variance + tilt.normal / tilt.variance);
    if (!covariance) return std::nullopt;
    step = *covariance * (place.gradient / place.variance + tilt.gradient / tilt.variance);
    place.estimate_variance(step, *covariance, floor);
    tilt.estimate_variance(step, *covariance, floor);
  }
  const auto covariance = inverse_of(place.normal / place.students_variance() + tilt.normal / tilt.students_variance());
  if (!covariance) return std::nullopt;
  return WeightedPose{moved(start, step), *covariance};
}

}  // namespace sheen
