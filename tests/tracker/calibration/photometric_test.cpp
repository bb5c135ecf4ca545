// SPDX-License-Identifier: Apache-2.0
// The truth is a simulated camera: power law, black level, the fourth power of the cosine, noise, rounding.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/simulation/sensor_response.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"
#include "tracker/calibration/photometric_study.h"

namespace sheen {
namespace {

constexpr int kWidth = 160, kHeight = 120, kCells = 10;
const std::vector<double> kExposures{0.03, 0.06, 0.12, 0.25, 0.5, 1, 2};

ImageF painted(const std::function<double(double x, double y)>& light, int channels = 3) {
  ImageF image(kWidth, kHeight, channels);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < channels; ++c) image.at(x, y, c) = static_cast<float>(light(x, y));
  return image;
}

/// Smooth, of many brightnesses.
ImageF scene() {
  return painted([](double x, double y) { return 0.08 + 0.85 * x / kWidth * (0.3 + 0.7 * y / kHeight); });
}

CellImage seen(const ImageF& radiance, double exposure, const SensorResponse& camera, std::uint64_t seed,
               int levels = 255) {
  CellImage cells = cells_of(stored_values(radiance, exposure, camera, levels, seed), "", kCells);
  cells.levels = levels;
  cells.name = "image" + std::to_string(seed);
  return cells;
}

std::vector<CellImage> sweep(const SensorResponse& camera, std::uint64_t seed, int levels = 255) {
  std::vector<CellImage> images;
  for (std::size_t i = 0; i < kExposures.size(); ++i)
    images.push_back(seen(scene(), kExposures[i], camera, 100 * seed + i, levels));
  return images;
}

const ImageF kDarkness = painted([](double, double) { return 0; });

SensorResponse camera_of(double gamma, double black, const SensorNoise& noise = {}) {
  SensorResponse camera;
  camera.black = black;
  camera.gamma = gamma;
  camera.noise = noise;
  return camera;
}

/// (estimate - truth) / uncertainty of many calibrations: as often beyond one and two as a normal deviate, and no bias.
void expect_as_uncertain_as_it_says(const std::vector<double>& deviations) {
  const auto count = static_cast<double>(deviations.size());
  double sum = 0, squares = 0;
  int beyond = 0;
  for (const double d : deviations) {
    sum += d / count;
    squares += d * d / count;
    beyond += std::abs(d) > 3;
  }
  EXPECT_LT(std::sqrt(squares), 1.4);
  EXPECT_GT(std::sqrt(squares), 0.5);  // nor does it say far too much
  EXPECT_LT(std::abs(sum), 0.5);
  EXPECT_LE(beyond, 0.03 * count);
}

TEST(Response, ALinearCamerasBlackLevelIsFound) {
  std::vector<double> deviations;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const ResponseFit fit = fit_response(sweep(camera_of(1, 0.06), seed), kExposures, {});
    ASSERT_EQ(fit.response.model(), ResponseModel::kLinear) << seed;
    deviations.push_back((fit.black_level() - 0.06) / fit.black_level_uncertainty());
    EXPECT_LT(fit.black_level_uncertainty(), 0.1 / 255);
    EXPECT_TRUE(fit.saturation_seen);
    EXPECT_EQ(fit.saturation, 1);
  }
  expect_as_uncertain_as_it_says(deviations);
}

TEST(Response, AGammaIsFoundWithTheBlackLevelUnderIt) {
  std::vector<double> gammas, blacks;
  const double black = std::pow(0.01, 1 / 1.8);
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const ResponseFit fit = fit_response(sweep(camera_of(1.8, 0.01), seed), kExposures, {});
    ASSERT_EQ(fit.response.model(), ResponseModel::kGamma) << seed;
    gammas.push_back((fit.response.gamma() - 1.8) / fit.gamma_uncertainty());
    blacks.push_back((fit.black_level() - black) / fit.black_level_uncertainty());
  }
  expect_as_uncertain_as_it_says(gammas);
  expect_as_uncertain_as_it_says(blacks);
}

/// A curve that none of the formulas is: as a photograph's tones are steepened.
double steep(double light) {
  const double encoded = srgb_encode(static_cast<float>(std::clamp(light, 0.0, 1.0)));
  return encoded - 0.06 * std::sin(2 * M_PI * encoded);
}

TEST(Response, ACurveThatNoFormulaIsIsFollowed) {
  std::vector<double> deviations;
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    std::vector<CellImage> images;
    for (std::size_t i = 0; i < kExposures.size(); ++i) {
      ImageF light = scene();
      for (std::size_t k = 0; k < light.size(); ++k) light.data()[k] *= static_cast<float>(kExposures[i]);
      add_sensor_noise(light, {}, 100 * seed + i);
      for (std::size_t k = 0; k < light.size(); ++k)
        light.data()[k] = static_cast<float>(std::round(255 * steep(light.data()[k])) / 255);
      images.push_back(cells_of(light, "", kCells));
    }
    const ResponseFit fit = fit_response(images, kExposures, {});
    ASSERT_EQ(fit.response.model(), ResponseModel::kCurve) << seed;
    for (const double light : {0.1, 0.2, 0.4, 0.6}) {
      const double top = fit.highest;
      double low = 0, high = 1;  // the light of the highest value
      for (int k = 0; k < 60; ++k) (steep(0.5 * (low + high)) < top ? low : high) = 0.5 * (low + high);
      const double value = steep(light), truth = light / low;
      const double found = fit.response(value).light / fit.response(top).light;
      worst = std::max(worst, std::abs(found - truth) / truth);
      deviations.push_back((found - truth) / fit.relative_uncertainty(value));
    }
  }
  EXPECT_LT(worst, 0.02);
  RecordProperty("worst", std::to_string(worst));
}

TEST(Response, TwelveBitsAreReadAsFinelyAsTheyAre) {
  SensorResponse camera = camera_of(1, 0.015, {.read_sigma = 0.15, .shot = 0.003});
  camera.saturation = 0.95;
  const ResponseFit fit = fit_response(sweep(camera, 1, 4095), kExposures, {});
  EXPECT_EQ(fit.response.model(), ResponseModel::kLinear);
  EXPECT_NEAR(fit.black_level(), 0.015, 3 * fit.black_level_uncertainty());
  EXPECT_LT(fit.black_level_uncertainty(), 0.02 / 255);
  EXPECT_TRUE(fit.saturation_seen);
  EXPECT_NEAR(fit.saturation, 0.95, 1e-3);
  EXPECT_LT(fit.nonlinearity(), 1e-6);
}

TEST(Response, DarkFramesThatDisagreeAreNamed) {
  const SensorResponse camera = camera_of(1, 0.06);
  const std::vector<CellImage> images = sweep(camera, 1);
  const std::vector<CellImage> dark{seen(kDarkness, 0, camera, 7)}, leaky{seen(kDarkness, 0, camera_of(1, 0.08), 8)};
  PhotometricStudy study{.names = std::vector<std::string>(kExposures.size(), "x"), .size = {kWidth, kHeight}};
  study.response = fit_response(images, kExposures, dark);
  const auto says = [&](const char* text) {
    const auto all = warnings(study);
    return std::any_of(all.begin(), all.end(), [&](const std::string& w) { return w.find(text) != w.npos; });
  };
  EXPECT_FALSE(says("dark frames"));
  EXPECT_NEAR(study.response.black_level(), 0.06, 3 * study.response.black_level_uncertainty());
  study.response = fit_response(images, kExposures, leaky);
  EXPECT_TRUE(says("dark frames"));
}

// The mean of a dark frame is lower than the black level where noise meets a bent response.
TEST(Response, DarkFramesDoNotBendAGamma) {
  const SensorResponse camera = camera_of(2, 0.01);
  const std::vector<CellImage> dark{seen(kDarkness, 0, camera, 7)};
  const ResponseFit fit = fit_response(sweep(camera, 1), kExposures, dark);
  EXPECT_NEAR(fit.response.gamma(), 2, 4 * fit.gamma_uncertainty());
  EXPECT_NEAR(fit.black_level(), 0.1, 4 * fit.black_level_uncertainty());
  EXPECT_NEAR(fit.dark_value, 0.1, 4 * fit.dark_uncertainty);
}

TEST(Response, AnExposureThatIsNotWhatItSaysIsNamed) {
  std::vector<double> said = kExposures;
  said[3] *= 1.05;  // it got less light than that
  const ResponseFit fit = fit_response(sweep(camera_of(1, 0.06), 3), said, {});
  for (std::size_t i = 0; i < said.size(); ++i)
    if (i != 3) EXPECT_GT(std::abs(fit.exposure_error[3]), 3 * std::abs(fit.exposure_error[i])) << i;
  EXPECT_LT(fit.exposure_error[3], -0.02);
}

TEST(Response, SaysWhichImagesAreMissing) {
  const std::vector<CellImage> images = sweep(camera_of(1, 0.06), 1);
  expect_error<Error>([&] { fit_response({images.data(), 2}, {kExposures.data(), 2}, {}); }, {"at least 3 images"});
  std::vector<double> unknown = kExposures;
  unknown[2] = 0;
  expect_error<Error>([&] { fit_response(images, unknown, {}); }, {images[2].name, "--exposures"});
  expect_error<Error>([&] { fit_response(images, std::vector<double>(kExposures.size(), 1), {}); }, {"factor of 2"});
  const std::vector<CellImage> dark(3, seen(kDarkness, 0, camera_of(1, 0), 1));
  expect_error<Error>([&] { fit_response(dark, {kExposures.data(), 3}, {}); }, {"cells"});
}

// ---- The vignette

SensorResponse lens_of(double gamma, double black, std::uint64_t seed) {
  SensorResponse camera = camera_of(gamma, black);
  camera.focal_px = 260;
  camera.cx = 79.5 + 6 * std::sin(double(seed));
  camera.cy = 59.5 + 6 * std::cos(1.7 * double(seed));
  return camera;
}

/// Brightest off the middle, and twice as bright as the darkest place.
double uneven(double x, double y) {
  return 0.7 * std::exp(-(std::pow(x - 50, 2) + std::pow(y - 30, 2)) / (2 * 110 * 110));
}

Response exact(double gamma, double black) {
  Response response(gamma == 1 ? ResponseModel::kLinear : ResponseModel::kGamma);
  Eigen::VectorXd step(response.unknowns());
  step[0] = black;
  if (gamma != 1) step[1] = gamma - response.gamma();
  response.move(step);
  return response;
}

/// Greatest relative error over the image; lens and calibration may differ by a factor.
double vignette_error(const VignetteFit& fit, const SensorResponse& camera) {
  const auto ratio = [&](double x, double y) { return fit.vignette.at(x, y, fit.size) / camera.vignette(x, y); };
  double worst = 0;
  for (int y = 0; y < kHeight; y += 7)
    for (int x = 0; x < kWidth; x += 7) worst = std::max(worst, std::abs(ratio(x, y) / ratio(80, 60) - 1));
  return worst;
}

TEST(Vignette, IsFoundOnAnEvenTargetWithinWhatItSays) {
  std::vector<double> deviations;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const SensorResponse camera = lens_of(2, 0.01, seed);
    std::vector<FlatImage> flats;
    for (std::uint64_t i = 0; i < 2; ++i)
      flats.push_back({seen(painted([](double, double) { return 0.6; }), 1, camera, 10 * seed + i), {}});
    const VignetteFit fit = fit_vignette(flats, exact(2, 0.01), 1, TargetLight::kEven);
    EXPECT_TRUE(fit.determined());
    EXPECT_LT(vignette_error(fit, camera), 0.015);
    const double corner = fit.vignette.at(0, 0, fit.size), truth = camera.vignette(0, 0);
    deviations.push_back((corner / truth - 1) / fit.uncertainty_at(0, 0));
    EXPECT_NEAR(fit.vignette.cx, camera.cx, 5 * fit.centre_uncertainty_px);
    EXPECT_NEAR(fit.vignette.cy, camera.cy, 5 * fit.centre_uncertainty_px);
  }
  expect_as_uncertain_as_it_says(deviations);
}

std::vector<FlatImage> moved_target(const SensorResponse& camera, const std::vector<TargetMove>& moves) {
  std::vector<FlatImage> flats;
  for (const TargetMove& move : moves) {
    const double c = std::cos(move.turn_rad), s = std::sin(move.turn_rad);
    const ImageF light = painted([&](double x, double y) {
      const double u = x - 79.5 - move.shift_px.x(), v = y - 59.5 - move.shift_px.y();
      return uneven(79.5 + c * u + s * v, 59.5 - s * u + c * v);
    });
    flats.push_back({seen(light, 1, camera, flats.size()), move});
  }
  return flats;
}

TEST(Vignette, IsToldApartFromUnevenLightByMoves) {
  const SensorResponse camera = lens_of(1, 0, 2);
  const std::vector<TargetMove> moves{{0, {0, 0}},    {0, {40, 0}},       {0, {-40, 10}},  {0, {0, 35}},
                                      {0, {10, -35}}, {M_PI / 2, {0, 0}}, {M_PI, {20, 20}}};
  const VignetteFit fit = fit_vignette(moved_target(camera, moves), exact(1, 0), 1, TargetLight::kUnknown);
  EXPECT_TRUE(fit.determined());
  EXPECT_LT(vignette_error(fit, camera), 0.02);
  EXPECT_LT(fit.left_radial, 0.005);
}

TEST(Vignette, SaysWhereLightAndLensCannotBeToldApart) {
  const SensorResponse camera = lens_of(1, 0, 2);
  const auto fit = [&](const std::vector<TargetMove>& moves) {
    return fit_vignette(moved_target(camera, moves), exact(1, 0), 1, TargetLight::kUnknown);
  };
  const VignetteFit one = fit({{0, {0, 0}}});
  EXPECT_FALSE(one.determined());
  // Light that is round about the middle looks the same however it is turned.
  EXPECT_FALSE(fit({{0, {0, 0}}, {M_PI / 2, {0, 0}}, {M_PI, {0, 0}}}).determined());
  PhotometricStudy study{.size = {kWidth, kHeight}};
  study.response = fit_response(sweep(camera_of(1, 0), 1), kExposures, {});
  study.names.resize(kExposures.size());
  study.vignette = one;
  const auto all = warnings(study);
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [](const std::string& w) {
    return w.find("light and lens cannot be told apart") != w.npos;
  }));
  EXPECT_TRUE(calibration_of(study).photometry.vignette.none());
}

TEST(Balance, MakesGreyOfGrey) {
  SensorResponse camera = lens_of(1, 0.04, 1);
  camera.tint = {0.6, 1, 0.45};
  PhotometricStudy study{.size = {kWidth, kHeight}};
  study.response = fit_response(sweep(camera, 1), kExposures, {});
  const CellImage grey = seen(painted([](double, double) { return 0.5; }), 1, camera, 77);
  const BalanceFit fit = fit_balance({&grey, 1}, {}, study.response, nullptr);
  EXPECT_NEAR(fit.gains[0], 1 / 0.6, 4 * fit.gains[0] * fit.uncertainty[0]);
  EXPECT_EQ(fit.gains[1], 1);
  EXPECT_NEAR(fit.gains[2], 1 / 0.45, 4 * fit.gains[2] * fit.uncertainty[2]);
  EXPECT_LT(fit.uncertainty[2], 0.01);
  expect_error<Error>([&] { fit_balance({&grey, 1}, {10, 10, 5, 5}, study.response, nullptr); }, {"--patch"});
}

TEST(CellImage, KeepsTheColoursOfAMosaicApart) {
  ImageF mosaic(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      mosaic.at(x, y) = x % 2 == 1 && y % 2 == 0 ? 0.25f : x % 2 == 0 && y % 2 == 1 ? 0.75f : 0.5f;
  const CellImage cells = cells_of(mosaic, "GR", 8);
  ASSERT_EQ(cells.channels, 3);
  for (const int channel : {0, 1, 2}) {
    EXPECT_FLOAT_EQ(cells.at(3, 2, channel).mean, 0.25f * float(channel + 1));
    EXPECT_FLOAT_EQ(cells.at(3, 2, channel).variance, 0);
  }
}

TEST(CellImage, IsReadFromAFileAsItWasWritten) {
  const TempFolder folder;
  ImageU8 image(64, 48, 3, 128);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) image.at(x, y, 0) = 51;  // red
  write_png(folder.path() / "a.png", image);
  const CellImage cells = read_cells(folder.path() / "a.png", {}, 8);
  ASSERT_EQ(cells.channels, 3);
  EXPECT_FLOAT_EQ(cells.at(0, 0, 0).mean, 0.2f);
  EXPECT_FLOAT_EQ(cells.at(7, 5, 2).mean, 128 / 255.0f);
  EXPECT_EQ(cells.levels, 255);
  EXPECT_EQ(cells.exposure_s, 0) << "a PNG without EXIF says nothing";
  expect_error([&] { read_cells(folder.path() / "a.png", {.mosaic = "RG"}, 8); }, {"a.png", "--mosaic"});
  expect_error([&] { read_cells(folder.write("b.png", "no image"), {}, 8); }, {"b.png", "no image"});
}

}  // namespace
}  // namespace sheen
