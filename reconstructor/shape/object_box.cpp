// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/object_box.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr std::size_t kFewestCameras = 3;
constexpr int kCells = 48;      // along a side of the space that is searched
constexpr double kReach = 0.8;  // half of that side, of the cameras' median distance

struct Axes {
  std::vector<Eigen::Vector3d> eyes, directions;
};

Axes axes_of(std::span<const PosedCamera> cameras) {
  Axes axes;
  for (const PosedCamera& camera : cameras) {
    axes.eyes.push_back(camera_centre(camera.camera_from_object));
    axes.directions.push_back(camera.camera_from_object.rotation.conjugate() * Eigen::Vector3d::UnitZ());
  }
  return axes;
}

/// Least sum of distances (not of squares: some may look elsewhere), by reweighting.
Eigen::Vector3d point_nearest_to(const Axes& axes) {
  constexpr int kRounds = 20;
  constexpr double kParallel = 1e-6;  // least eigenvalue over the number of axes
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  std::vector<double> weights(axes.eyes.size(), 1);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < axes.eyes.size(); ++i) {
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axes.directions[i] * axes.directions[i].transpose();
      a += weights[i] * across;
      b += weights[i] * across * axes.eyes[i];
      sum += weights[i];
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a / sum);
    if (!(solver.eigenvalues()[0] > kParallel))
      throw Error("the cameras look in parallel: no place is common to them; the shape needs views from several sides");
    point = a.ldlt().solve(b);
    std::vector<double> distances;
    for (std::size_t i = 0; i < axes.eyes.size(); ++i) {
      const Eigen::Vector3d from_eye = point - axes.eyes[i];
      distances.push_back((from_eye - axes.directions[i].dot(from_eye) * axes.directions[i]).norm());
    }
    const double least = 1e-3 * (point - axes.eyes[0]).norm() + 1e-12;
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = 1 / std::max(distances[i], least);
  }
  return point;
}

bool sees(const PosedCamera& camera, const Eigen::Vector3d& point) {
  const auto pixel = camera.camera.project(camera.camera_from_object * point);
  return pixel && camera.camera.contains(*pixel);
}

}  // namespace

Eigen::AlignedBox3d box_seen_by(double share, std::span<const PosedCamera> cameras) {
  if (cameras.size() < kFewestCameras)
    throw Error("only " + std::to_string(cameras.size()) + " of the images have a pose; a shape needs " +
                std::to_string(kFewestCameras) + " or more, from several sides");
  const Axes axes = axes_of(cameras);
  const Eigen::Vector3d middle = point_nearest_to(axes);
  std::vector<double> distances;
  for (const Eigen::Vector3d& eye : axes.eyes) distances.push_back((eye - middle).norm());
  const double reach = kReach * median(distances);
  Eigen::AlignedBox3d box;
  for (int z = 0; z <= kCells; ++z)
    for (int y = 0; y <= kCells; ++y)
      for (int x = 0; x <= kCells; ++x) {
        const Eigen::Vector3d place = Eigen::Vector3d(x, y, z) / kCells * 2 - Eigen::Vector3d::Ones();
        const Eigen::Vector3d point = middle + reach * place;
        const auto seeing = std::count_if(cameras.begin(), cameras.end(),
                                          [&](const PosedCamera& camera) { return sees(camera, point); });
        if (static_cast<double>(seeing) >= share * static_cast<double>(cameras.size())) box.extend(point);
      }
  if (box.isEmpty() || !(box.sizes().minCoeff() > 0))
    throw Error("no place is seen by enough of the images; a shape needs views of one object from several sides");
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(2 * reach / kCells);
  return {box.min() - margin, box.max() + margin};
}

PixelBox part_with(const Eigen::AlignedBox3d& box, const PosedCamera& camera) {
  const Camera whole = camera.camera;
  Eigen::AlignedBox2d part;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d seen =
        camera.camera_from_object * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if (!(seen.z() > 1e-6 * box.diagonal().norm())) return {0, 0, whole.width, whole.height};  // the eye is in it
    part.extend(Eigen::Vector2d(whole.fx * seen.x() / seen.z() + whole.cx, whole.fy * seen.y() / seen.z() + whole.cy));
  }
  const auto within = [](double value, int size) { return static_cast<int>(std::clamp(value, 0.0, double(size))); };
  return {within(std::floor(part.min().x()), whole.width), within(std::floor(part.min().y()), whole.height),
          within(std::ceil(part.max().x()) + 1, whole.width), within(std::ceil(part.max().y()) + 1, whole.height)};
}

}  // namespace sheen
