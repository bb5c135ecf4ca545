// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "common/capture/linear_capture.h"
#include "common/simulation/sensor_response.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5, kLowest = 0.55;
constexpr double kHalfDiagonal = 100;  ///< pixels, of `camera_at`
constexpr double kTangent2 = 0.3;      ///< of the angle of the image's corner: 59 % of the light comes there
constexpr double kGamma = 2, kBlack = 0.02;

SensorResponse bad_camera() {
  SensorResponse camera;
  camera.focal_px = kHalfDiagonal / std::sqrt(kTangent2);
  camera.cx = 79.5;
  camera.cy = 59.5;
  camera.black = kBlack;
  camera.gamma = kGamma;
  camera.tint = {0.8, 1, 0.7};
  return camera;
}

/// What a perfect calibration of it says, written out: the series of the fourth power of the cosine.
Photometry its_photometry() {
  Photometry photometry;
  for (int value = 0; value < 256; ++value)
    photometry.response[value] =
        static_cast<float>(std::max(0.0, (std::pow(value / 255.0, kGamma) - kBlack) / (1 - kBlack)));
  photometry.vignette = {79.5, 59.5, {-2 * kTangent2, 3 * kTangent2 * kTangent2, -4 * std::pow(kTangent2, 3)}};
  photometry.white_balance = {1 / 0.8f, 1, 1 / 0.7f};
  return photometry;
}

std::vector<Capture> through(const SensorResponse& camera, std::vector<Capture> images) {
  for (std::size_t i = 0; i < images.size(); ++i)
    images[i].image = stored_rgb8(to_linear_rgb(images[i].image), 1, camera, i + 1);
  return images;
}

TEST(Photometry, ALightFieldIsTheOneOfAPerfectCamera) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  const std::vector<Capture> perfect = captures(scene, eyes(20, kDistance, kLowest));
  std::vector<Capture> unknown = through(bad_camera(), perfect), calibrated = unknown;
  for (Capture& image : calibrated) image.photometry = its_photometry();
  const auto psnr_db = [&](const std::vector<Capture>& images) {
    SurfaceLightField model(object.mesh, plain_options());
    ingest_all(model, images);
    return compare(*model.snapshot(), scene, eyes(6, kDistance, kLowest + 0.05)).psnr_db();
  };
  const double of_perfect = psnr_db(perfect), of_calibrated = psnr_db(calibrated), of_unknown = psnr_db(unknown);
  EXPECT_GT(of_perfect, 45);
  EXPECT_GT(of_calibrated, 40) << "noise and 8 bits are left";
  EXPECT_LT(of_unknown, of_calibrated - 15);
  RecordProperty("perfect", std::to_string(of_perfect));
  RecordProperty("calibrated", std::to_string(of_calibrated));
  RecordProperty("unknown", std::to_string(of_unknown));
}

TEST(Photometry, ImagesWithoutItAreReadAsBefore) {
  const Object object = square_object();
  Capture image = through(bad_camera(), captures({object.surface, analytic::diffuse(0.2)}, {{0.1, 0, 0.5}}))[0];
  image.exposure.black_level = 0.03f;
  image.exposure.white_balance = {1.5f, 1, 0.9f};
  EXPECT_EQ(linear_radiance(image), to_linear_rgb(image.image, 0.03f, image.exposure.white_balance.data()));
  EXPECT_STREQ(photometric_knowledge(image), "not measured");
  image.photometry = its_photometry();
  EXPECT_STREQ(photometric_knowledge(image), "response and vignette measured");
  image.photometry->vignette.k = {};
  EXPECT_STREQ(photometric_knowledge(image), "response measured, vignette not");
}

}  // namespace
}  // namespace sheen
