// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kernel.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr Eigen::Index kAtOnce = 8;  // what a register holds, or two
using Some = Eigen::Array<float, kAtOnce, 1>;

/// Squares of half the chords between a direction and those from `first` on; 0 beyond the last.
Some squared_half_chords(const Eigen::Matrix3Xf& directions, Eigen::Index first, const Eigen::Vector3f& direction) {
  Some squares = Some::Zero();
  const float* const from = directions.data() + 3 * first;
  const auto square = [&](Eigen::Index i) {
    const float x = from[3 * i] - direction.x(), y = from[3 * i + 1] - direction.y(),
                z = from[3 * i + 2] - direction.z();
    return 0.25f * (x * x + y * y + z * z);
  };
  if (const Eigen::Index count = directions.cols() - first; count >= kAtOnce)
    for (Eigen::Index i = 0; i < kAtOnce; ++i) squares[i] = square(i);  // all at once
  else
    for (Eigen::Index i = 0; i < count; ++i) squares[i] = square(i);
  return squares;
}

/// Half a chord is the sine of half the angle; the tangent is halved twice more, tan(x / 2) = tan x / (1 + sqrt(1 +
/// tan^2 x)), until the series of its arc is exact to rounding.
Some angles(const Some& squared_half_chords) {
  const Some sine = squared_half_chords.sqrt(), cosine = (1 - squared_half_chords).max(0).sqrt();
  const Some quarter = sine / (1 + cosine);
  const Some eighth = quarter / (1 + (1 + quarter.square()).sqrt());
  const Some z = -eighth.square();  // not beyond tan^2 (pi / 8) = 0.17
  constexpr int kTerms = 9;
  Some series = Some::Constant(1.0f / (2 * kTerms - 1));
  for (int term = kTerms - 2; term >= 0; --term) series = series * z + 1.0f / static_cast<float>(2 * term + 1);
  return 8 * eighth * series;
}

template <typename Angles>
Angles of_angles(const ViewKernel& kernel, const Angles& angles) {
  if (kernel.shape == KernelShape::kExponential) return (angles * (-1 / kernel.scale_rad)).exp();
  const Angles t = angles * (std::sqrt(3.0f) / kernel.scale_rad);
  return (1 + t) * (-t).exp();
}

/// What `value` makes of the angles between a direction and all of `directions`, some at a time.
template <typename Value>
void of_each_angle(const Eigen::Matrix3Xf& directions, const Eigen::Vector3f& direction, const Value& value,
                   Eigen::Ref<Eigen::VectorXf> out) {
  for (Eigen::Index first = 0; first < out.size(); first += kAtOnce) {
    const Eigen::Index count = std::min(kAtOnce, out.size() - first);
    out.segment(first, count) = value(angles(squared_half_chords(directions, first, direction))).head(count);
  }
}

}  // namespace

float angle_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  // Only where they are opposite is it less accurate, 1e-3: no kernel tells angles apart there.
  return 2 * std::asin(std::min(1.0f, 0.5f * (a - b).norm()));
}

Eigen::MatrixXf angles_between(const Eigen::Matrix3Xf& directions) {
  Eigen::MatrixXf result(directions.cols(), directions.cols());
  for (Eigen::Index j = 0; j < directions.cols(); ++j)
    of_each_angle(
        directions, directions.col(j), [](const Some& some) { return some; }, result.col(j));
  return result;
}

float evaluate(const ViewKernel& kernel, float angle_rad) {
  return of_angles(kernel, Eigen::Array<float, 1, 1>(angle_rad))[0];
}

Eigen::MatrixXf covariances(const ViewKernel& kernel, const Eigen::MatrixXf& angles_rad) {
  return of_angles<Eigen::ArrayXXf>(kernel, angles_rad.array());
}

Eigen::VectorXf covariances(const ViewKernel& kernel, const Eigen::Matrix3Xf& directions,
                            const Eigen::Vector3f& direction) {
  Eigen::VectorXf k(directions.cols());
  of_each_angle(
      directions, direction, [&](const Some& some) { return of_angles(kernel, some); }, k);
  return k;
}

}  // namespace sheen
