// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace sheen {

/// Saved models name them by these numbers.
enum class KernelShape {
  kMatern = 0,       ///< Matern 3/2, k(t) = (1 + sqrt(3) t / scale) exp(-sqrt(3) t / scale): smooth lobes
  kExponential = 1,  ///< k(t) = exp(-t / scale): kinks as at shadows and parallax, and long tails
};

/// Covariance of view coefficients over the angle t between two view directions; `nugget` is added on the diagonal.
struct ViewKernel {
  float scale_rad = 0.3f;
  float nugget = 0.1f;
  KernelShape shape = KernelShape::kMatern;
  bool operator==(const ViewKernel&) const = default;
};

/// The kernels that a vertex chooses from.
inline constexpr std::array<ViewKernel, 6> kViewKernels{{{0.3f, 0.02f},
                                                         {0.6f, 0.05f},
                                                         {0.6f, 1.0f},
                                                         {0.6f, 0.02f, KernelShape::kExponential},
                                                         {1.2f, 0.02f, KernelShape::kExponential},
                                                         {1.2f, 0.1f, KernelShape::kExponential}}};

/// Angle between two unit vectors, accurate for small ones.
float angle_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b);

/// The same of all unit directions with each other, many at a time, in radians: views x views.
Eigen::MatrixXf angles_between(const Eigen::Matrix3Xf& directions);

/// k(t), without the nugget, of any angles in radians.
float evaluate(const ViewKernel& kernel, float angle_rad);
Eigen::MatrixXf covariances(const ViewKernel& kernel, const Eigen::MatrixXf& angles_rad);

/// k of the angles between unit directions (3 x views) and one: what an eye costs a vertex.
Eigen::VectorXf covariances(const ViewKernel& kernel, const Eigen::Matrix3Xf& directions,
                            const Eigen::Vector3f& direction);

}  // namespace sheen
