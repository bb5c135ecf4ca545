// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/lit_scene.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace sheen {
namespace {

constexpr std::array<std::array<int, 3>, 2> kTriangles{{{0, 3, 2}, {0, 2, 1}}};  // seen by the camera from the front

/// Top left, top right, bottom right, bottom left: the outer edges of the pixels there.
std::array<Eigen::Vector2d, 4> picture_corners(const ImageSize& size) {
  const double right = size.width - 0.5, bottom = size.height - 0.5;
  return {{{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}}};
}

bool any_coincide(const Eigen::Matrix3Xd& points) {
  constexpr double kSame = 1e-6;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if ((points.col(i) - points.col(j)).norm() < kSame * points.norm()) return true;
  return false;
}

}  // namespace

std::vector<PointKernel> light_kernels(const Eigen::Matrix3Xd& lights) {
  std::vector<PointKernel> kernels;
  Eigen::Matrix3Xd flat = lights;
  flat.row(2).setZero();
  // A drift of degree 1 is what a matt surface does; it comes first, for scenes with few lights.
  for (const int degree : {1, 2, 3})
    for (const PointKernelShape shape :
         {PointKernelShape::kCubic, PointKernelShape::kThinPlate, PointKernelShape::kLinear})
      kernels.push_back({shape, degree, 1});
  if (!any_coincide(flat))
    for (const PointKernelShape shape : {PointKernelShape::kCubic, PointKernelShape::kThinPlate})
      kernels.push_back({shape, 1, 0});
  return kernels;
}

Mesh picture_plane(const PosedCamera& camera) {
  const double depth = camera.camera_from_object.translation.z() > 0 ? camera.camera_from_object.translation.z() : 1;
  const Rigid3 object_from_camera = camera.camera_from_object.inverse();
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector2d& corner : picture_corners({camera.camera.width, camera.camera.height})) {
    const Eigen::Vector3d point((corner.x() - camera.camera.cx) / camera.camera.fx,
                                (corner.y() - camera.camera.cy) / camera.camera.fy, 1);
    corners.push_back(object_from_camera * (depth * point));
  }
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c] : kTriangles)
    triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
  return mesh_of(corners, std::move(triangles));
}

Eigen::Vector2f picture_place(const ImageSize& size, std::uint32_t triangle, float u, float v) {
  const auto corners = picture_corners(size);
  const auto corner = [&](std::size_t c) { return corners[static_cast<std::size_t>(kTriangles[triangle][c])]; };
  return ((1.0 - u - v) * corner(0) + u * corner(1) + v * corner(2)).cast<float>();
}

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
