// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/undistortion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "reconstructor/radiance/radiance_image.h"

namespace sheen {

UndistortedPicture undistorted(const Camera& camera, const ImageF& linear, const ImageU8& mask) {
  UndistortedPicture out{.camera = camera, .linear = ImageF(camera.width, camera.height, 3), .mask = {}};
  out.camera.lens = LensModel::kOpenCv;
  out.camera.distortion = {};
  out.mask = ImageU8(camera.width, camera.height, 1);
  const RadianceImage photograph(linear);
  constexpr double kRounding = 1e-6;  // pixels, at the border
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto from = camera.project({(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1});
      if (!from || !camera.contains(*from, -kRounding)) continue;
      const Eigen::Vector3f rgb = photograph.sample(from->cast<float>(), 1);
      std::copy_n(rgb.data(), 3, out.linear.pixel(x, y));
      const auto nearest = [](double pixel) { return static_cast<int>(std::lround(pixel)); };
      const bool counts = mask.empty() || mask.at(nearest(from->x()), nearest(from->y())) != 0;
      out.mask.at(x, y) = counts ? 255 : 0;
    }
  });
  const auto counts = [](std::uint8_t value) { return value != 0; };
  if (std::all_of(out.mask.data(), out.mask.data() + out.mask.size(), counts)) out.mask = {};
  return out;
}

}  // namespace sheen
