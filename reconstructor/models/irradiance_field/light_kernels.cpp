// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/light_kernels.h"

namespace sheen {
namespace {

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

}  // namespace sheen
