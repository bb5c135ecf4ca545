// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/reprojection.h"

#include <Eigen/Cholesky>

#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kRelativeStep = 1e-6;  ///< of the distance, for central differences
constexpr double kConverged = 1e-12;    ///< relative decrease of the cost
constexpr double kMaxDamping = 1e12;

using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

double huber_loss(double error, double delta) {
  return error <= delta ? error * error : 2 * delta * error - delta * delta;
}

std::optional<double> robust_cost(const Camera& camera, std::span<const Correspondence> points, const Rigid3& pose,
                                  double delta) {
  double cost = 0;
  for (const Correspondence& c : points) {
    const auto pixel = camera.project(pose * c.point_object);
    if (!pixel) return std::nullopt;
    cost += huber_loss((*pixel - c.pixel).norm(), delta);
  }
  return cost;
}

struct NormalEquations {
  Matrix6 weighted = Matrix6::Zero();
  Matrix6 unweighted = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

std::optional<NormalEquations> linearise(const Camera& camera, std::span<const Correspondence> points,
                                         const Rigid3& pose, double delta) {
  NormalEquations equations;
  for (const Correspondence& c : points) {
    const auto projection = project_with_jacobian(camera, pose, c.point_object);
    if (!projection) return std::nullopt;
    const Jacobian26& j = projection->jacobian;
    const Eigen::Vector2d error = projection->pixel - c.pixel;
    const double length = error.norm();
    const double weight = length <= delta ? 1 : delta / length;
    const Matrix6 jtj = j.transpose() * j;
    equations.unweighted += jtj;
    equations.weighted += weight * jtj;
    equations.gradient += weight * (j.transpose() * error);
  }
  return equations;
}

}  // namespace

Rigid3 moved(const Rigid3& pose, const Vector6& step) {
  const Eigen::Vector3d w = step.head<3>();
  const double angle = w.norm();
  const Eigen::Quaterniond turn =
      angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, w / angle)) : Eigen::Quaterniond::Identity();
  return {(turn * pose.rotation).normalized(), turn * pose.translation + step.tail<3>()};
}

std::optional<Projection> project_with_jacobian(const Camera& camera, const Rigid3& pose,
                                                const Eigen::Vector3d& point_object) {
  const Eigen::Vector3d point = pose * point_object;
  const auto pixel = camera.project(point);
  if (!pixel) return std::nullopt;
  const double h = kRelativeStep * point.norm();
  Eigen::Matrix<double, 2, 3> by_point;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
    const auto plus = camera.project(point + step), minus = camera.project(point - step);
    if (!plus || !minus) return std::nullopt;
    by_point.col(axis) = (*plus - *minus) / (2 * h);
  }
  Projection projection{*pixel, {}};
  projection.jacobian.leftCols<3>() = -by_point * skew(point);
  projection.jacobian.rightCols<3>() = by_point;
  return projection;
}

std::optional<RefinedPose> refine_pose(const Camera& camera, std::span<const Correspondence> points,
                                       const Rigid3& start, double huber_px) {
  RefinedPose best{.camera_from_object = start};
  const auto start_cost = robust_cost(camera, points, start, huber_px);
  auto equations = linearise(camera, points, start, huber_px);
  if (!start_cost || !equations) return std::nullopt;
  best.cost = *start_cost;
  double damping = 1e-4;
  for (int i = 0; i < kMaxIterations && damping < kMaxDamping; ++i) {
    Matrix6 damped = equations->weighted;
    damped.diagonal() *= 1 + damping;
    const Vector6 step = damped.ldlt().solve(-equations->gradient);
    if (!step.allFinite()) return std::nullopt;
    const Rigid3 candidate = moved(best.camera_from_object, step);
    const auto cost = robust_cost(camera, points, candidate, huber_px);
    if (!cost || !(*cost < best.cost)) {
      // At the minimum no step lowers the cost any more: rounding decides.
      if (cost && *cost - best.cost <= kConverged * best.cost) break;
      damping *= 10;
      continue;
    }
    const double decrease = best.cost - *cost;
    best.camera_from_object = candidate;
    best.cost = *cost;
    equations = linearise(camera, points, candidate, huber_px);
    if (!equations) return std::nullopt;
    if (decrease <= kConverged * best.cost) break;
    damping = std::max(damping / 10, 1e-12);
  }
  best.information = equations->unweighted;
  return best;
}

}  // namespace sheen
