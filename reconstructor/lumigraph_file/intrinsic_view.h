// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"
#include "reconstructor/lumigraph_file/light_set.h"

namespace sheen {

using ImageHalf = Image<Eigen::half>;
using ImageS8 = Image<std::int8_t>;

/// A view of the intrinsic lumigraph (001 sec. 4.3), as it is stored. The image of light i at a pixel is
///   R (ambient + V_i b.s_i) + e_i
/// with the reflectance R (001 eq. 5), visibility V_i, the incidence s_i (`LightSet::incidence`) and what a Lambertian
/// surface does not explain, e_i. b stands for the normal, times what R leaves to it.
struct IntrinsicView {
  PosedCamera from;
  ImageF depth;             ///< z in camera coordinates, metres; 0 where no surface is known
  ImageHalf reflectance;    ///< RGB
  ImageHalf slope;          ///< b, 3 channels
  ImageHalf ambient;        ///< light where the lamp's does not arrive
  std::vector<int> lights;  ///< of the light set, ascending
  std::vector<ImageU8> arrives;
  std::vector<ImageS8> residual;  ///< RGB: e = sign(r) residual_unit r^2, 0 where the light does not arrive
  float residual_unit = 0;

  Eigen::Vector3f residual_at(std::size_t light, std::size_t pixel) const {
    const std::int8_t* r = residual[light].data() + 3 * pixel;
    const auto value = [&](int c) {
      return residual_unit * static_cast<float>(r[c]) * std::abs(static_cast<float>(r[c]));
    };
    return {value(0), value(1), value(2)};
  }
};

}  // namespace sheen
