// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/next_view.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kTilt_deg = 35;
constexpr double kFromBorder = 0.25;  ///< of the image: where the outer ninths' targets have their middle
constexpr std::size_t kFewestCorners = 6;

struct Lean {
  double turn = 0, nod = 0;  ///< as ViewAdvice has them, in kTilt_deg
  const char* words = "";
};
constexpr Lean kLeans[] = {{0, 0, "facing the camera"},
                           {1, 0, "right edge 35 degrees nearer"},
                           {-1, 0, "left edge 35 degrees nearer"},
                           {0, 1, "lower edge 35 degrees nearer"},
                           {0, -1, "upper edge 35 degrees nearer"}};
struct Size {
  double height;  ///< of the target's diagonal, in heights of the image
  const char* words;
};
constexpr Size kSizes[] = {{0.5, "half as high"}, {0.9, "nearly as high"}};
constexpr const char* kPlaces[3][3] = {{"in the upper left", "in the upper middle", "in the upper right"},
                                       {"on the left", "in the middle", "on the right"},
                                       {"in the lower left", "in the lower middle", "in the lower right"}};

/// The pose of a view that was used, turned so that the target faces the camera.
Eigen::Quaterniond facing(const Calibration& calibration) {
  for (const CalibratedView& view : calibration.views) {
    if (!view.used) continue;
    const Eigen::Vector3d normal = view.camera_from_target.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d axis = normal.z() < 0 ? Eigen::Vector3d(-Eigen::Vector3d::UnitZ()) : Eigen::Vector3d::UnitZ();
    return Eigen::Quaterniond::FromTwoVectors(normal, axis) * view.camera_from_target.rotation;
  }
  return Eigen::Quaterniond::Identity();
}

}  // namespace

NextViews::NextViews(const Calibration& calibration, const CalibrationTarget& target)
    : calibration_(calibration), target_(target) {
  for (int i = 0; i < kIntrinsics; ++i)
    if (calibration.fit->free[i]) free_.push_back(i);
  const auto count = static_cast<Eigen::Index>(free_.size());
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j) covariance(i, j) = calibration.covariance(free_[i], free_[j]);
  covariance /= calibration.noise_px * calibration.noise_px;
  information_ = covariance.llt().solve(Eigen::MatrixXd::Identity(count, count));
  rms_ = rms_with(information_);
}

Eigen::MatrixXd NextViews::information_of(const TargetView& view, const Rigid3& camera_from_target) const {
  Bundle bundle{.camera = calibration_.camera,
                .camera_from_object = {camera_from_target},
                .points = target_.points,
                .free = {.intrinsics = calibration_.fit->free}};
  for (const TargetSighting& s : view.sightings) bundle.sightings.push_back({0, s.point, s.pixel});
  const Eigen::MatrixXd full = information(bundle);
  const auto count = static_cast<Eigen::Index>(free_.size());
  const Eigen::MatrixXd cross = full.topRightCorner(count, 6);
  return full.topLeftCorner(count, count) - cross * full.bottomRightCorner(6, 6).ldlt().solve(cross.transpose());
}

double NextViews::rms_with(const Eigen::MatrixXd& information) const {
  const auto count = static_cast<Eigen::Index>(free_.size());
  const Eigen::MatrixXd part = information.llt().solve(Eigen::MatrixXd::Identity(count, count));
  IntrinsicsCovariance covariance = IntrinsicsCovariance::Zero();
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j) covariance(free_[i], free_[j]) = part(i, j);
  return projection_uncertainty(calibration_.camera, covariance).rms();
}

double NextViews::uncertainty_left(const TargetView& view, const Rigid3& camera_from_target) const {
  if (view.sightings.size() < kFewestCorners) return 1;
  return rms_with(information_ + information_of(view, camera_from_target)) / rms_;
}

TargetView NextViews::seen_from(const Rigid3& camera_from_target) const {
  TargetView view;
  for (std::size_t i = 0; i < target_.points.size(); ++i)
    if (const auto pixel = calibration_.camera.project(camera_from_target * target_.points[i]);
        pixel && calibration_.camera.contains(*pixel))
      view.sightings.push_back({static_cast<int>(i), *pixel});
  return view;
}

WantedView NextViews::best() const {
  const Camera& camera = calibration_.camera;
  const Eigen::Quaterniond face = facing(calibration_);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : target_.points) box.extend(point);
  WantedView best;
  const auto consider = [&](const Eigen::Vector3d& ray, const Size& size, const Lean& lean, const char* place) {
    const Eigen::Quaterniond rotation = Eigen::AngleAxisd(lean.turn * kTilt_deg * kDegree, Eigen::Vector3d::UnitY()) *
                                        Eigen::AngleAxisd(-lean.nod * kTilt_deg * kDegree, Eigen::Vector3d::UnitX()) *
                                        face;
    const double distance = camera.fy * box.diagonal().norm() / (size.height * camera.height);
    const Rigid3 pose{rotation, distance * ray.normalized() - rotation * box.center()};
    const TargetView view = seen_from(pose);
    if (target_.kind == TargetKind::kChessboard && view.sightings.size() < target_.points.size()) return;
    const double left = uncertainty_left(view, pose);
    if (left < best.uncertainty_left)
      best = {pose, left, format("target %s, %s as the image, %s", place, size.words, lean.words)};
  };
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const auto ray = camera.ray({(kFromBorder + (1 - 2 * kFromBorder) * column / 2) * camera.width,
                                   (kFromBorder + (1 - 2 * kFromBorder) * row / 2) * camera.height});
      if (!ray) continue;
      for (const Size& size : kSizes)
        for (const Lean& lean : kLeans) consider(*ray, size, lean, kPlaces[row][column]);
    }
  return best;
}

}  // namespace sheen
