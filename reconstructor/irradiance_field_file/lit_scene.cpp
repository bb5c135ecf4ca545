// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/lit_scene.h"

#include <Eigen/Eigenvalues>

namespace sheen {

std::optional<Eigen::Vector3d> LightPlane::meet(const Eigen::Vector3d& point) const {
  constexpr double kFlattest = 0.05;  // sine of an angle to the plane: beyond it no light ever was
  const double towards = normal.dot(point);
  if (!(towards > kFlattest * point.norm())) return std::nullopt;
  return point * (distance / towards);
}

std::optional<LightPlane> light_plane(const LitScene& scene) {
  constexpr double kFlat = 1e-3, kBeside = 0.05;
  if (scene.kind != LightKind::kPoint || scene.lights.cols() < 3) return std::nullopt;
  const Eigen::Vector3d middle = scene.lights.rowwise().mean();
  const Eigen::Matrix3Xd about = scene.lights.colwise() - middle;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(about * about.transpose());
  const Eigen::Vector3d spread = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
  Eigen::Vector3d normal = axes.eigenvectors().col(0);
  if (normal.dot(middle) < 0) normal = -normal;
  const LightPlane plane{normal, normal.dot(middle)};
  const bool flat = spread[0] <= kFlat * spread[1] && spread[1] > kFlat * spread[2];
  if (!flat || !(plane.distance > kBeside * about.colwise().norm().maxCoeff())) return std::nullopt;
  return plane;
}

}  // namespace sheen
