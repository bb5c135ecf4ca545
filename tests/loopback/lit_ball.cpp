// SPDX-License-Identifier: Apache-2.0
#include "tests/loopback/lit_ball.h"

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "common/base/files.h"
#include "common/image/color.h"
#include "common/image/image_io.h"

namespace sheen::testing {
namespace {

ImageU8 matt_ball(const Eigen::Vector3d& light) {
  constexpr int kWidth = 60, kHeight = 44;
  ImageF image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double u = (x - 30) / 36.0, v = (22 - y) / 36.0, r = u * u + v * v;
      const Eigen::Vector3d normal = r < 0.25 ? Eigen::Vector3d(u, v, std::sqrt(1 - r)) : Eigen::Vector3d::UnitZ();
      const double shade = std::max(0.0, normal.dot(light));
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>((0.3 + 0.3 * c) * shade);
    }
  return to_srgb8(image);
}

}  // namespace

void LitBall::write() const {
  std::string text = std::to_string(lights) + "\n";
  make_folder(folder);
  for (int i = 0; i < lights; ++i) {
    const double z = 0.55 + 0.45 * (i + 0.5) / lights, s = std::sqrt(1 - z * z), a = 2.4 * i + turn;
    const Eigen::Vector3d light(s * std::cos(a), s * std::sin(a), z);
    const std::string name = "light" + std::to_string(i) + ".png";
    write_png(folder / name, matt_ball(light));
    text += name + " " + std::to_string(light.x()) + " " + std::to_string(light.y()) + " " + std::to_string(light.z()) +
            "\n";
  }
  write_file(list(), text);
}

}  // namespace sheen::testing
