// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <memory>

#include "common/base/errors.h"

namespace sheen {
namespace {

using Pose = Eigen::Matrix<double, 6, 1>;  // rotation vector, translation

struct ReprojectionError {
  LensModel lens;
  Eigen::Vector2d pixel;

  template <typename T>
  bool operator()(const T* intrinsics, const T* pose, const T* point, T* error) const {
    T in_camera[3], projected[2];
    ceres::AngleAxisRotatePoint(pose, point, in_camera);
    for (int i = 0; i < 3; ++i) in_camera[i] += pose[3 + i];
    if (!project_point(lens, intrinsics, in_camera, projected)) return false;
    for (int i = 0; i < 2; ++i) error[i] = T(pixel[i]) - projected[i];
    return true;
  }
};
using ReprojectionCost = ceres::AutoDiffCostFunction<ReprojectionError, 2, kIntrinsics, 6, 3>;

std::unique_ptr<ReprojectionCost> cost_of(const Bundle& bundle, const BundleSighting& sighting) {
  return std::make_unique<ReprojectionCost>(new ReprojectionError{bundle.camera.lens, sighting.pixel});
}

std::vector<Pose> pose_parameters(const Bundle& bundle) {
  std::vector<Pose> poses;
  for (const Rigid3& pose : bundle.camera_from_object) {
    const Eigen::AngleAxisd turn(pose.rotation);
    poses.emplace_back();
    poses.back() << turn.angle() * turn.axis(), pose.translation;
  }
  return poses;
}

Rigid3 rigid(const Pose& pose) {
  const double angle = pose.head<3>().norm();
  if (angle < 1e-300) return {Eigen::Quaterniond::Identity(), pose.tail<3>()};
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, pose.head<3>() / angle)), pose.tail<3>()};
}

std::vector<int> fixed_intrinsics(const BundleFreedom& free) {
  std::vector<int> fixed;
  for (int i = 0; i < kIntrinsics; ++i)
    if (!free.intrinsics[i]) fixed.push_back(i);
  return fixed;
}

/// Where the points are free too, images do not tell a similarity of everything. The first pose and the number of the
/// others that the scale moves most stay, so that the normal equations can be solved.
void hold_gauge(const Bundle& bundle, std::vector<Pose>& poses, ceres::Problem& problem) {
  problem.SetParameterBlockConstant(poses[0].data());
  const Eigen::Vector3d first = camera_centre(bundle.camera_from_object[0]);
  std::size_t view = 0;
  int axis = 0;
  double most = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Rigid3& pose = bundle.camera_from_object[i];
    const Eigen::Vector3d by_scale = pose.rotation * (camera_centre(pose) - first);
    int largest = 0;
    if (const double length = by_scale.cwiseAbs().maxCoeff(&largest); length > most) {
      most = length;
      view = i;
      axis = largest;
    }
  }
  if (view > 0) problem.SetManifold(poses[view].data(), new ceres::SubsetManifold(6, {3 + axis}));
}

}  // namespace

Intrinsics intrinsics_of(const Camera& camera) {
  Intrinsics values;
  values << camera.fx, camera.fy / camera.fx, camera.cx, camera.cy,
      Eigen::Map<const Eigen::Matrix<double, 5, 1>>(camera.distortion.data());
  return values;
}

Camera with_intrinsics(Camera camera, const Intrinsics& values) {
  camera.fx = values[0];
  camera.fy = values[0] * values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  for (int i = 0; i < 5; ++i) camera.distortion[i] = values[4 + i];
  return camera;
}

int BundleFreedom::intrinsics_count() const {
  return static_cast<int>(std::count(intrinsics.begin(), intrinsics.end(), true));
}

void solve(Bundle& bundle, double huber_px) {
  Intrinsics intrinsics = intrinsics_of(bundle.camera);
  std::vector<Pose> poses = pose_parameters(bundle);
  ceres::Problem problem;
  for (const BundleSighting& s : bundle.sightings)
    problem.AddResidualBlock(cost_of(bundle, s).release(), huber_px > 0 ? new ceres::HuberLoss(huber_px) : nullptr,
                             intrinsics.data(), poses[s.view].data(), bundle.points[s.point].data());
  const std::vector<int> fixed = fixed_intrinsics(bundle.free);
  if (fixed.size() == kIntrinsics)
    problem.SetParameterBlockConstant(intrinsics.data());
  else if (!fixed.empty())
    problem.SetManifold(intrinsics.data(), new ceres::SubsetManifold(kIntrinsics, fixed));
  if (bundle.free.points)
    hold_gauge(bundle, poses, problem);
  else
    for (const BundleSighting& s : bundle.sightings) problem.SetParameterBlockConstant(bundle.points[s.point].data());

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;  // the same images give the same camera, to the last bit
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) throw Error("bundle adjustment failed: " + summary.message);
  bundle.camera = with_intrinsics(bundle.camera, intrinsics);
  for (std::size_t view = 0; view < poses.size(); ++view) bundle.camera_from_object[view] = rigid(poses[view]);
}

std::vector<Eigen::Vector2d> residuals(const Bundle& bundle) {
  const Intrinsics intrinsics = intrinsics_of(bundle.camera);
  std::vector<Eigen::Vector2d> errors;
  errors.reserve(bundle.sightings.size());
  for (const BundleSighting& s : bundle.sightings) {
    const Eigen::Vector3d in_camera = bundle.camera_from_object[s.view] * bundle.points[s.point];
    Eigen::Vector2d pixel;
    if (!project_point(bundle.camera.lens, intrinsics.data(), in_camera.data(), pixel.data()))
      pixel.setConstant(INFINITY);
    errors.push_back(s.pixel - pixel);
  }
  return errors;
}

Eigen::MatrixXd information(const Bundle& bundle) {
  const Intrinsics intrinsics = intrinsics_of(bundle.camera);
  const std::vector<Pose> poses = pose_parameters(bundle);
  const int camera_count = bundle.free.intrinsics_count(), view_count = static_cast<int>(poses.size());
  const int first_point = camera_count + 6 * view_count;
  const int size = first_point + (bundle.free.points ? 3 * static_cast<int>(bundle.points.size()) : 0);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);

  constexpr int kMost = kIntrinsics + 6 + 3;
  Eigen::Matrix<double, 2, kIntrinsics, Eigen::RowMajor> by_camera;
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
  std::array<int, kMost> places{};
  Eigen::Matrix<double, 2, kMost> row;
  for (const BundleSighting& s : bundle.sightings) {
    const double* parameters[] = {intrinsics.data(), poses[s.view].data(), bundle.points[s.point].data()};
    double* jacobians[] = {by_camera.data(), by_pose.data(), by_point.data()};
    double error[2];
    if (!cost_of(bundle, s)->Evaluate(parameters, error, jacobians)) throw Error("a point lies behind the camera");
    int count = 0;
    const auto add = [&](int place, const Eigen::Vector2d& column) {
      places[count] = place;
      row.col(count++) = column;
    };
    for (int i = 0; i < kIntrinsics; ++i)
      if (bundle.free.intrinsics[i]) add(count, by_camera.col(i));
    for (int i = 0; i < 6; ++i) add(camera_count + 6 * s.view + i, by_pose.col(i));
    if (bundle.free.points)
      for (int i = 0; i < 3; ++i) add(first_point + 3 * s.point + i, by_point.col(i));
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j) sum(places[i], places[j]) += row.col(i).dot(row.col(j));
  }
  return sum;
}

PixelDerivative pixel_derivative(const Camera& camera, const Eigen::Vector3d& ray) {
  const ReprojectionCost cost(new ReprojectionError{camera.lens, Eigen::Vector2d::Zero()});
  const Intrinsics intrinsics = intrinsics_of(camera);
  const Pose here = Pose::Zero();
  const double* parameters[] = {intrinsics.data(), here.data(), ray.data()};
  Eigen::Matrix<double, 2, kIntrinsics, Eigen::RowMajor> by_camera;
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_pose;
  double* jacobians[] = {by_camera.data(), by_pose.data(), nullptr};
  double error[2];
  if (!cost.Evaluate(parameters, error, jacobians)) throw Error("a ray does not reach the lens");
  return {-by_camera, -by_pose.leftCols<3>()};  // the cost is seen - predicted
}

}  // namespace sheen
