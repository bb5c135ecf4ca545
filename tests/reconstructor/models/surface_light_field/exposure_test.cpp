// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/image/linear_reader.h"
#include "reconstructor/radiance/exposure_gain.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5, kLowest = 0.55;

Capture brighter(Capture capture, double gain) {
  ImageF pixels = to_linear_rgb(capture.image);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels.data()[i] *= static_cast<float>(gain);
  capture.image = analytic::float_image(pixels);
  capture.exposure.locked = false;
  return capture;
}

SurfaceLightFieldOptions options_with(ExposureCompensation exposure) {
  SurfaceLightFieldOptions options = plain_options();
  options.exposure = exposure;
  return options;
}

struct Setting {
  double exposure_s, gain_db;
};
constexpr Setting kSettings[] = {{0.01, 0}, {0.02, 0}, {0.005, 6}, {0.004, 0}, {0.01, -6}};

std::vector<Capture> at_many_settings(std::vector<Capture> images, bool locked) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto& [exposure_s, gain_db] = kSettings[i % 5];
    images[i] = brighter(images[i], exposure_s / 0.01 * std::pow(10, gain_db / 20));
    images[i].exposure.exposure_s = exposure_s;
    images[i].exposure.gain_db = gain_db;
    images[i].exposure.locked = locked;
  }
  return images;
}

TEST(Exposure, KnownExposuresGiveTheModelOfEqualOnes) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.2)};
  const std::vector<Capture> equal = captures(scene, eyes(20, kDistance, kLowest));
  SurfaceLightField reference(object.mesh, plain_options());
  ingest_all(reference, equal);
  for (const bool locked : {false, true}) {  // locked, then set again and locked again, is no other case
    const std::vector<Capture> images = at_many_settings(equal, locked);
    for (const auto compensation : {ExposureCompensation::kKnown, ExposureCompensation::kEstimate}) {
      SurfaceLightField model(object.mesh, options_with(compensation));
      for (std::size_t i = 0; i < images.size(); ++i) {
        const IngestReport report = model.ingest(images[i]);
        ASSERT_EQ(report.status, IngestStatus::kAccepted);
        const auto& [exposure_s, gain_db] = kSettings[i % 5];
        EXPECT_NEAR(report.exposure_gain, exposure_s / 0.01 * std::pow(10, gain_db / 20), 1e-5);
      }
      EXPECT_EQ(model.figures().rank_histogram, reference.figures().rank_histogram);
      const auto a = model.snapshot(), b = reference.snapshot();
      const auto seen = a->shader_for({{0.1, 0.1, 0.4}}), expected = b->shader_for({{0.1, 0.1, 0.4}});
      for (std::uint32_t t = 0; t < object.mesh->triangles.size(); ++t)
        EXPECT_LT((seen->shade(t, 0.3f, 0.4f).rgb - expected->shade(t, 0.3f, 0.4f).rgb).cwiseAbs().maxCoeff(), 1e-3f);
    }
  }
}

TEST(Exposure, OffTakesGreyLevelsAsTheyCome) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  const std::vector<Capture> images = at_many_settings(captures(scene, eyes(10, kDistance, kLowest)), false);
  SurfaceLightField model(object.mesh, options_with(ExposureCompensation::kOff));
  for (const Capture& image : images) EXPECT_EQ(model.ingest(image).exposure_gain, 1);
  EXPECT_GT(compare(*model.snapshot(), scene, eyes(3, kDistance, 0.7)).rms, 0.05);
}

// A camera with automatic exposure: the gain follows the direction smoothly. What a view shows is the scene times its
// gain, up to the one factor that no image can tell.
TEST(Exposure, UnknownGainsOfADiffuseSceneAreRecoveredWithinTwoPercent) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  const auto gain = [](const Eigen::Vector3d& eye) {
    const Eigen::Vector3d d = eye.normalized();
    return std::exp(0.3 * d.x() - 0.2 * d.y());
  };
  const std::vector<Eigen::Vector3d> from = eyes(30, kDistance, kLowest);
  SurfaceLightField model(object.mesh, options_with(ExposureCompensation::kEstimate));
  for (const Eigen::Vector3d& eye : from) ingest_all(model, {brighter(captures(scene, {eye})[0], gain(eye))});
  EXPECT_GT(share_of_rank_up_to(model, 1), 0.95) << "brightness is no view dependence";
  const auto snapshot = model.light_field_snapshot();
  const double first = snapshot->exposure().at(from[0]) / gain(from[0]);
  for (const Eigen::Vector3d& eye : from) EXPECT_NEAR(snapshot->exposure().at(eye) / gain(eye) / first, 1, 0.02);
  for (const Eigen::Vector3d& eye : eyes(5, kDistance, kLowest + 0.08, 0.95)) {
    Scene brightened = scene;
    brightened.radiance = [&, radiance = scene.radiance](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
      return Eigen::Vector3d(gain(eye) * radiance(p, d));
    };
    EXPECT_LT(compare(*snapshot, brightened, {eye}).rms, 0.01);
  }
}

TEST(Exposure, GainsWithoutRhymeAreTakenOutOfTheModel) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  std::vector<Capture> images = captures(scene, eyes(24, kDistance, kLowest));
  std::mt19937 engine(2);
  std::normal_distribution<double> log_gain(0, 0.15);
  for (std::size_t i = 1; i < images.size(); ++i) images[i] = brighter(images[i], std::exp(log_gain(engine)));
  images[0].exposure.locked = false;
  SurfaceLightField model(object.mesh, options_with(ExposureCompensation::kEstimate));
  ingest_all(model, images);
  EXPECT_GT(share_of_rank_up_to(model, 1), 0.9);
  const auto snapshot = model.snapshot();
  const auto shader = snapshot->shader_for({{0.1, 0.1, 0.45}});
  const float exposure = model.light_field_snapshot()->exposure().at({0.1, 0.1, 0.45});
  for (std::uint32_t t = 0; t < object.mesh->triangles.size(); ++t) {
    const Eigen::Vector3f a = object.mesh->corner(t, 0), b = object.mesh->corner(t, 1), c = object.mesh->corner(t, 2);
    const Eigen::Vector3d truth = scene.radiance(((a + b + c) / 3).cast<double>(), {0, 0, 1});
    const Eigen::Vector3f level = shader->shade(t, 1 / 3.0f, 1 / 3.0f).rgb / exposure;
    if (a.cwiseAbs().maxCoeff() > 0.07f) continue;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(level[k] / truth[k], 1, 0.02) << "at the level of the first image";
  }
}

TEST(RobustGain, IsTheMedianOfWhatTheSurfacesSay) {
  std::vector<float> ratios(1000, std::log(1.25f));
  EXPECT_NEAR(robust_gain(ratios), 1.25f, 1e-4);
  std::fill(ratios.begin(), ratios.end(), std::log(1.25f));
  std::fill_n(ratios.begin(), 300, 2.0f);  // a highlight came
  EXPECT_NEAR(robust_gain(ratios), 1.25f, 0.01);
}

TEST(RobustGain, BrokenRatiosAreLeftOutAndFewSayNothing) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  std::vector<float> ratios(200, nan);
  EXPECT_EQ(robust_gain(ratios), 1);
  EXPECT_EQ(robust_gain({}), 1);
  for (int i = 0; i < 100; ++i) ratios[2 * i] = std::log(0.8f);
  ratios[1] = inf;
  ratios[3] = -inf;
  EXPECT_NEAR(robust_gain(ratios), 0.8f, 1e-4);
  std::vector<float> few(19, 1.0f);
  EXPECT_EQ(robust_gain(few), 1);
}

TEST(RobustGain, DisagreementDrawsItTowardsOne) {
  std::mt19937 engine(1);
  std::normal_distribution<float> wide(0.3f, 1.0f);
  std::vector<float> ratios(30);
  for (float& r : ratios) r = wide(engine);
  const float gain = robust_gain(ratios);
  EXPECT_GT(gain, 0.9f);
  EXPECT_LT(gain, std::exp(0.3f));
}

}  // namespace
}  // namespace sheen
