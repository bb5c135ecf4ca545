// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "common/camera/camera.h"

namespace sheen {

/// Intrinsics as an estimator sees them: f, fy / fx, cx, cy, then the five numbers of `Camera::distortion`.
inline constexpr int kIntrinsics = 9;

/// `Camera::project` before the focal length is applied, for any scalar (automatic derivatives): camera coordinates ->
/// distorted normalised coordinates. False where the point is not in front of the lens. Unlike `Camera::project` it
/// goes on past the fold of the polynomial: an optimiser needs a value everywhere.
template <typename T>
bool distorted_point(LensModel lens, const T* k, const T* point, T* out) {
  using std::atan2;
  using std::sqrt;
  if (lens == LensModel::kFisheye) {
    const T r2 = point[0] * point[0] + point[1] * point[1];
    if (!(r2 > T(1e-18))) {
      if (!(point[2] > T(1e-9))) return false;
      out[0] = point[0] / point[2];
      out[1] = point[1] / point[2];
      return true;
    }
    const T r = sqrt(r2);
    const T theta = atan2(r, point[2]), t2 = theta * theta;
    const T scale = theta * (T(1) + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r;
    out[0] = point[0] * scale;
    out[1] = point[1] * scale;
    return true;
  }
  if (!(point[2] > T(1e-9))) return false;
  const T x = point[0] / point[2], y = point[1] / point[2];
  const T r2 = x * x + y * y;
  const T radial = T(1) + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  out[0] = x * radial + T(2) * k[2] * x * y + k[3] * (r2 + T(2) * x * x);
  out[1] = y * radial + k[2] * (r2 + T(2) * y * y) + T(2) * k[3] * x * y;
  return true;
}

/// Pixel of a point in camera coordinates. `intrinsics`: kIntrinsics numbers, `pixel`: two.
template <typename T>
bool project_point(LensModel lens, const T* intrinsics, const T* point, T* pixel) {
  T distorted[2];
  if (!distorted_point(lens, intrinsics + 4, point, distorted)) return false;
  pixel[0] = intrinsics[0] * distorted[0] + intrinsics[2];
  pixel[1] = intrinsics[0] * intrinsics[1] * distorted[1] + intrinsics[3];
  return true;
}

}  // namespace sheen
