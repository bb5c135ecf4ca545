// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

inline constexpr int kHarmonicDegree = 6;
inline constexpr int kHarmonics = (kHarmonicDegree + 1) * (kHarmonicDegree + 1);
using Harmonics = Eigen::Matrix<float, kHarmonics, 1>;

/// Real spherical harmonics up to degree 6 at a unit vector, orthonormal over the sphere; (l, m) stands at l^2 + l + m,
/// with the sines of m * azimuth at negative m.
Harmonics spherical_harmonics(const Eigen::Vector3f& direction);

}  // namespace sheen
