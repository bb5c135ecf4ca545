// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/spherical_harmonics.h"

#include <array>
#include <cmath>

namespace sheen {
namespace {

using Table = std::array<std::array<float, kHarmonicDegree + 1>, kHarmonicDegree + 1>;

/// sqrt((2 l + 1) / (4 pi) * (l - m)! / (l + m)!), with sqrt(2) more for m > 0.
Table normalisation() {
  Table table{};
  for (int l = 0; l <= kHarmonicDegree; ++l)
    for (int m = 0; m <= l; ++m) {
      double value = (2 * l + 1) / (4 * M_PI);
      for (int k = l - m + 1; k <= l + m; ++k) value /= k;
      table[l][m] = static_cast<float>(std::sqrt(m > 0 ? 2 * value : value));
    }
  return table;
}

}  // namespace

Harmonics spherical_harmonics(const Eigen::Vector3f& direction) {
  static const Table scale = normalisation();
  const float x = direction.x(), y = direction.y(), z = direction.z();
  Harmonics out;
  float cosine = 1, sine = 0;  // sin(polar)^m times cosine and sine of m * azimuth
  float diagonal = 1;          // P_m^m / sin(polar)^m
  for (int m = 0; m <= kHarmonicDegree; ++m) {
    float below = 0, legendre = diagonal;  // P_(l-1)^m and P_l^m, both over sin(polar)^m
    for (int l = m; l <= kHarmonicDegree; ++l) {
      const int centre = l * l + l;
      out[centre + m] = scale[l][m] * legendre * cosine;
      if (m > 0) out[centre - m] = scale[l][m] * legendre * sine;
      const float above = (static_cast<float>(2 * l + 1) * z * legendre - static_cast<float>(l + m) * below) /
                          static_cast<float>(l - m + 1);
      below = legendre;
      legendre = above;
    }
    const float next = x * cosine - y * sine;
    sine = x * sine + y * cosine;
    cosine = next;
    diagonal *= static_cast<float>(2 * m + 1);
  }
  return out;
}

}  // namespace sheen
