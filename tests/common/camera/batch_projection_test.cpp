// SPDX-License-Identifier: Apache-2.0
#include "common/camera/batch_projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace sheen {
namespace {

constexpr std::array<double, 5> kNoDistortion{};
constexpr std::array<double, 5> kBarrel{-0.3, 0.1, 0.001, -0.002, -0.01};
constexpr std::array<double, 5> kPincushion{0.2, 0.05, 0, 0, 0};

class BatchProjection : public testing::TestWithParam<std::pair<LensModel, std::array<double, 5>>> {};

TEST_P(BatchProjection, AgreesWithTheProjectionOfOnePoint) {
  const auto& [lens, distortion] = GetParam();
  const Camera camera{
      .width = 1024, .height = 768, .fx = 900, .fy = 910, .cx = 500, .cy = 390, .lens = lens, .distortion = distortion};
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(-3, 3);
  const std::size_t n = 5003;
  std::vector<float> x(n), y(n), z(n), px(n), py(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = uniform(engine), y[i] = uniform(engine), z[i] = uniform(engine);
  z[7] = 0;
  project(camera, x, y, z, px, py);
  std::size_t inside = 0, outside = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto pixel = camera.project({x[i], y[i], z[i]});
    if (pixel && camera.contains(*pixel)) {
      ++inside;
      EXPECT_LT((Eigen::Vector2d(px[i], py[i]) - *pixel).norm(), 1e-3) << i;
    } else if (!pixel) {
      ++outside;
      EXPECT_TRUE(std::isnan(px[i]) && std::isnan(py[i])) << i;
    }
  }
  EXPECT_GT(inside, 100u);
  EXPECT_GT(outside, 0u);
}

INSTANTIATE_TEST_SUITE_P(Lenses, BatchProjection,
                         testing::Values(std::pair(LensModel::kOpenCv, kNoDistortion),
                                         std::pair(LensModel::kOpenCv, kBarrel),
                                         std::pair(LensModel::kOpenCv, kPincushion),
                                         std::pair(LensModel::kFisheye, kBarrel)));

}  // namespace
}  // namespace sheen
