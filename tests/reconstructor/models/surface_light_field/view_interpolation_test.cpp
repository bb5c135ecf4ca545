// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_interpolation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/ring_model.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

constexpr std::size_t kKernels = kViewKernels.size();

/// All are as bad but one.
InterpolationErrors best_at(std::size_t kernel, float others = 1.5f) {
  InterpolationErrors errors;
  errors.fill(others);
  errors[kernel] = 1;
  return errors;
}

/// Of views in a row, 0.1 rad apart.
InterpolationErrors errors_of_row(const Eigen::MatrixXf& coefficients) {
  const Eigen::Index n = coefficients.cols();
  Eigen::Matrix3Xf directions(3, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const float angle = 0.1f * static_cast<float>(j);
    directions.col(j) = Eigen::Vector3f(std::sin(angle), 0, std::cos(angle));
  }
  return interpolation_errors(directions, coefficients, Eigen::VectorXf::Constant(n, 0.05f), Eigen::VectorXf());
}

/// Vertices 0 .. 8 in rows of three; 4 is in the middle.
Mesh small_square() {
  return square_mesh(0.1f, 0, 2);
}

TEST(InterpolationChoice, NeighboursOutvoteARingThatHardlyKnows) {
  InterpolationChoice choice(small_square());
  for (std::uint32_t v = 0; v < 9; ++v) choice.count(v, best_at(v == 4 ? 1 : 2, v == 4 ? 1.05f : 3));
  EXPECT_EQ(choice.choose(4).kernel, kViewKernels[2]);
}

TEST(InterpolationChoice, ARingThatKnowsKeepsItsOwn) {
  InterpolationChoice choice(small_square());
  for (std::uint32_t v = 0; v < 9; ++v) choice.count(v, best_at(v == 4 ? 1 : 2, v == 4 ? 50 : 1.5f));
  EXPECT_EQ(choice.choose(4).kernel, kViewKernels[1]);
  EXPECT_FALSE(choice.choose(4).drift);
}

TEST(InterpolationChoice, TheDriftIsNotForARingThatCannotHaveIt) {
  InterpolationChoice choice(small_square());
  for (std::uint32_t v = 0; v < 9; ++v) choice.count(v, best_at(kKernels + 2));
  EXPECT_TRUE(choice.choose(4).drift);
  InterpolationErrors without = best_at(1);
  std::fill(without.begin() + kKernels, without.end(), std::numeric_limits<float>::infinity());
  choice.count(4, without);
  EXPECT_FALSE(choice.choose(4).drift);
  EXPECT_TRUE(choice.choose(0).drift) << "a neighbour without says nothing against it";
}

TEST(InterpolationChoice, ClearedItKnowsNothingOfBefore) {
  InterpolationChoice choice(small_square()), fresh(small_square());
  for (std::uint32_t v = 0; v < 9; ++v) choice.count(v, best_at(2, 9));
  choice.clear();
  for (InterpolationChoice* c : {&choice, &fresh}) c->count(4, best_at(1, 1.01f));
  EXPECT_EQ(choice.choose(4), fresh.choose(4));
}

TEST(InterpolationErrors, OfViewsThatAreAlikeAreAlike) {
  for (const int n : {1, 2, 7, 40})
    for (const float value : {0.0f, 1e-30f, 0.37f, 3e37f}) {
      const InterpolationErrors errors = errors_of_row(Eigen::MatrixXf::Constant(6, n, value));
      for (std::size_t k = 0; k < kKernels; ++k) EXPECT_NEAR(errors[k], 1, 0.1) << n << " views of " << value;
    }
}

TEST(InterpolationErrors, DoNotDependOnTheScaleOfTheCoefficients) {
  const Eigen::MatrixXf y = gaussian_matrix(3, 20, 7);
  const InterpolationErrors expected = errors_of_row(y);
  EXPECT_EQ(*std::min_element(expected.begin(), expected.end()), 1);
  for (const float scale : {1e-30f, 1e30f}) {
    const InterpolationErrors errors = errors_of_row(scale * y);
    for (std::size_t k = 0; k < kKernels; ++k) EXPECT_NEAR(errors[k], expected[k], 1e-4 * expected[k]);
  }
}

TEST(InterpolationErrors, OfARingWithoutTermsAreAlike) {
  const InterpolationErrors errors = errors_of_row(Eigen::MatrixXf(0, 9));
  for (std::size_t k = 0; k < errors.size(); ++k)
    if (k < kKernels || std::isfinite(errors[k])) EXPECT_EQ(errors[k], 1);
}

TEST(InterpolationSchedule, EveryImageHasItsShareOfTheChoices) {
  constexpr int kSamples = 4, kRings = 200, kImages = 40;
  const std::vector<std::uint8_t> visible(kSamples, 1);
  std::vector<int> choices(kImages + 1, 0);
  for (unsigned phase = 0; phase < kRings; ++phase) {
    RingModel ring(kSamples, {}, phase);
    int last = 0;
    for (int image = 1; image <= kImages; ++image) {
      const Eigen::VectorXf column = gaussian_matrix(3 * kSamples, 1, static_cast<std::uint32_t>(image));
      const Eigen::Vector3f direction =
          Eigen::Vector3f(std::sin(0.1f * image), std::cos(0.07f * image), 1).normalized();
      if (!ring.absorb({shared_rows(column)}, visible, direction, 1, 1).wants_interpolation) continue;
      EXPECT_LE(image, std::max(7.0, std::ceil(1.4 * last + 1))) << "phase " << phase;
      ring.set_interpolation({kViewKernels[0], false});
      last = image;
      ++choices[image];
    }
    EXPECT_GE(last, kImages / 1.4 - 2) << "phase " << phase;
  }
  // Spread evenly over the logarithm of the number of images.
  for (int image = 8; image <= kImages; ++image)
    EXPECT_LE(choices[image], kRings * (1.2 * std::log(image / (image - 1.0)) / std::log(1.4) + 0.02)) << image;
}

TEST(Prediction, IsTheErrorOfThePictureThatTheModelWouldHavePainted) {
  const Object object = square_object();
  const auto grey = [&](float radiance) {
    return analytic::Scene{object.surface, [radiance](const Eigen::Vector3d&, const Eigen::Vector3d&) {
                             return Eigen::Vector3d(Eigen::Vector3d::Constant(radiance));
                           }};
  };
  SurfaceLightField model(object.mesh, plain_options());
  const std::vector<Eigen::Vector3d> eyes = analytic::eyes(13, 0.5, 0.55);
  const std::vector<Capture> known = captures(grey(0.4f), {eyes.begin(), eyes.end() - 1});
  EXPECT_TRUE(std::isnan(model.ingest(known[0]).predicted_psnr_db)) << "nothing came before";
  for (std::size_t i = 1; i < known.size(); ++i) EXPECT_GT(model.ingest(known[i]).predicted_psnr_db, 60);
  Capture brighter = captures(grey(0.5f), {eyes.back()})[0];
  brighter.sequence = 100;
  const double off = srgb_encode(0.5f) - srgb_encode(0.4f);
  EXPECT_NEAR(model.ingest(brighter).predicted_psnr_db, -20 * std::log10(off), 0.05);
}

}  // namespace
}  // namespace sheen
