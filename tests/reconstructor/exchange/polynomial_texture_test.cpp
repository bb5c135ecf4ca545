// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/polynomial_texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

constexpr int kWidth = 7, kHeight = 5;

/// A polynomial of its own for each pixel and colour, as the paper writes it.
double truth(int x, int y, int c, const Eigen::Vector3d& light) {
  const Eigen::Vector3d l = light.normalized();
  const double a = 0.02 * x, b = 0.03 * y, d = 0.1 * c;
  return 0.4 + a + (0.2 - d) * l.x() + (b - 0.1) * l.y() - a * l.x() * l.x() + 0.1 * l.x() * l.y() +
         (d - b) * l.y() * l.y();
}

ImageF picture(const Eigen::Vector3d& light) {
  ImageF image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(truth(x, y, c, light));
  return image;
}

PolynomialTexture fitted() {
  PolynomialFit fit(kWidth, kHeight);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d light(std::cos(2.4 * i) * i / 20, std::sin(2.4 * i) * i / 20, 1);
    fit.add(light, picture(light));
  }
  return fit.texture();
}

const Eigen::Vector3d kLight(0.3, -0.2, 0.9);

TEST(PolynomialTextureTest, FindsThePolynomial) {
  const ImageF shown = fitted().picture(kLight), expected = picture(kLight);
  for (std::size_t i = 0; i < shown.size(); ++i) EXPECT_NEAR(shown.data()[i], expected.data()[i], 1e-5);
}

TEST(PolynomialTextureTest, FewLightsOrACircleAreNotEnough) {
  PolynomialFit few(kWidth, kHeight), circle(kWidth, kHeight);
  for (int i = 0; i < 5; ++i) few.add({0.1 * i, 0.02 * i * i, 1}, picture(kLight));
  for (int i = 0; i < 30; ++i) circle.add({std::cos(0.2 * i), std::sin(0.2 * i), 1}, picture(kLight));
  EXPECT_THROW(few.texture(), ConfigError);
  EXPECT_THROW(circle.texture(), ConfigError);
}

/// The file as its description has it: text, then for each colour, from the lowest row up, six bytes per pixel.
TEST(PolynomialTextureTest, APtmFileIsAsItsFormatSays) {
  const TempFolder folder;
  const std::filesystem::path file = folder.path() / "a.ptm";
  write_ptm(file, fitted());
  const std::string bytes = read_file(file);
  std::istringstream head(bytes);
  std::string version, format;
  int width = 0, height = 0;
  std::array<double, 6> scale{};
  std::array<int, 6> bias{};
  head >> version >> format >> width >> height;
  for (double& value : scale) head >> value;
  for (int& value : bias) head >> value;
  EXPECT_EQ(version, "PTM_1.2");
  EXPECT_EQ(format, "PTM_FORMAT_RGB");
  ASSERT_EQ(width, kWidth);
  ASSERT_EQ(height, kHeight);
  const std::size_t start = static_cast<std::size_t>(head.tellg()) + 1;
  ASSERT_EQ(bytes.size(), start + 3 * 6 * kWidth * kHeight);
  const Eigen::Vector3d l = kLight.normalized();
  const std::array<double, 6> terms{l.x() * l.x(), l.y() * l.y(), l.x() * l.y(), l.x(), l.y(), 1};
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        double value = 0;
        for (std::size_t t = 0; t < 6; ++t) {
          const auto at = start + static_cast<std::size_t>(6 * ((c * kHeight + (kHeight - 1 - y)) * kWidth + x)) + t;
          value += terms[t] * scale[t] * (static_cast<unsigned char>(bytes[at]) - bias[t]);
        }
        EXPECT_NEAR(value, 255 * truth(x, y, c, kLight), 1.5);
      }
}

/// As OpenLIME's shader adds the planes up.
TEST(PolynomialTextureTest, ARelightFolderIsAsItsFormatSays) {
  const TempFolder folder;
  write_relight(folder.path() / "out", fitted());
  const auto info = nlohmann::json::parse(read_file(folder.path() / "out/info.json"));
  EXPECT_EQ(info["type"], "ptm");
  EXPECT_EQ(info["colorspace"], "rgb");
  EXPECT_EQ(info["nplanes"], 18);
  EXPECT_EQ(info["width"], kWidth);
  const auto& material = info["materials"][0];
  ASSERT_EQ(material["scale"].size(), 18u);
  const Eigen::Vector3d l = kLight.normalized();
  const std::array<double, 6> terms{1, l.x(), l.y(), l.x() * l.x(), l.x() * l.y(), l.y() * l.y()};
  ImageF sum(kWidth, kHeight, 3);
  for (std::size_t t = 0; t < 6; ++t) {
    const RawImage plane = read_image(folder.path() / "out" / ("plane_" + std::to_string(t) + ".jpg"));
    ASSERT_EQ(plane.width, kWidth);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double value = plane.bytes[i] / 255.0 - material["bias"][3 * t + i % 3].get<double>();
      sum.data()[i] += static_cast<float>(terms[t] * material["scale"][3 * t + i % 3].get<double>() * value);
    }
  }
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum.at(x, y, c), truth(x, y, c, kLight), 0.03);
  EXPECT_NE(read_file(folder.path() / "out/index.html").find("openlime.umd.js"), std::string::npos);
}

}  // namespace
}  // namespace sheen
