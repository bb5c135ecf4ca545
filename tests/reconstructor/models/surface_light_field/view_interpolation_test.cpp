// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_interpolation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/patch_model.h"
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

/// Vertices 0 .. 8 in rows of three, 4 in the middle; a patch for each of the eight triangles.
std::shared_ptr<const PatchShapes> small_square() {
  const Mesh mesh = square_mesh(0.1f, 0, 2);
  const MapLayout maps(std::vector<std::uint8_t>(mesh.triangles.size(), 2));
  return std::make_shared<const PatchShapes>(cut_into_patches(mesh, maps, {.triangles = 1}));
}

TEST(InterpolationChoice, PatchesRoundAVertexOutvoteOneThatHardlyKnows) {
  const auto shapes = small_square();
  InterpolationChoice choice(shapes);
  const std::uint32_t one = shapes->round(4).front().patch;
  for (std::uint32_t p = 0; p < 8; ++p) choice.count(p, best_at(p == one ? 1 : 2, p == one ? 1.05f : 3));
  EXPECT_EQ(choice.choose(4).kernel, kViewKernels[2]);
}

TEST(InterpolationChoice, PatchesThatKnowOutvoteAllOthers) {
  const auto shapes = small_square();
  InterpolationChoice choice(shapes);
  std::vector<bool> near(8);
  for (const PatchVertex& round : shapes->round(0)) near[round.patch] = true;
  for (std::uint32_t p = 0; p < 8; ++p) choice.count(p, best_at(near[p] ? 1 : 2, near[p] ? 50 : 1.5f));
  EXPECT_EQ(choice.choose(0).kernel, kViewKernels[1]);
  EXPECT_FALSE(choice.choose(0).drift);
}

TEST(InterpolationChoice, TheDriftIsNotForAVertexThatCannotHaveIt) {
  const auto shapes = small_square();
  InterpolationChoice choice(shapes);
  for (std::uint32_t p = 0; p < 8; ++p) choice.count(p, best_at(kKernels + 2));
  EXPECT_TRUE(choice.choose(4).drift);
  InterpolationErrors without = best_at(1);
  std::fill(without.begin() + kKernels, without.end(), std::numeric_limits<float>::infinity());
  choice.count(shapes->round(4).front().patch, without);
  EXPECT_TRUE(choice.choose(4).drift) << "a patch without says nothing against it";
  for (const PatchVertex& round : shapes->round(4)) choice.count(round.patch, without);
  EXPECT_FALSE(choice.choose(4).drift);
}

TEST(InterpolationChoice, ClearedItKnowsNothingOfBefore) {
  InterpolationChoice choice(small_square()), fresh(small_square());
  for (std::uint32_t p = 0; p < 8; ++p) choice.count(p, best_at(2, 9));
  choice.clear();
  const std::uint32_t one = small_square()->round(4).front().patch;
  for (InterpolationChoice* c : {&choice, &fresh}) c->count(one, best_at(1, 1.01f));
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

TEST(InterpolationErrors, OfAPatchWithoutTermsAreAlike) {
  const InterpolationErrors errors = errors_of_row(Eigen::MatrixXf(0, 9));
  for (std::size_t k = 0; k < errors.size(); ++k)
    if (k < kKernels || std::isfinite(errors[k])) EXPECT_EQ(errors[k], 1);
}

TEST(InterpolationSchedule, EveryImageHasItsShareOfTheChoices) {
  constexpr int kSide = 2, kSamples = lattice_samples(kSide), kPatches = 200, kImages = 40;
  const std::vector<std::uint8_t> visible(kSamples, 1);
  std::vector<int> choices(kImages + 1, 0);
  for (unsigned phase = 0; phase < kPatches; ++phase) {
    PatchModel patch({kSide}, 1, {}, {}, phase);
    int last = 0;
    for (int image = 1; image <= kImages; ++image) {
      const Eigen::VectorXf column = gaussian_matrix(3 * kSamples, 1, static_cast<std::uint32_t>(image));
      const Eigen::Vector3f direction =
          Eigen::Vector3f(std::sin(0.1f * image), std::cos(0.07f * image), 1).normalized();
      if (!patch.absorb(column, visible, direction, std::array{1.0f}).wants_interpolation) continue;
      EXPECT_LE(image, std::max(7.0, std::ceil(1.4 * last + 1))) << "phase " << phase;
      patch.interpolation_chosen();
      last = image;
      ++choices[image];
    }
    EXPECT_GE(last, kImages / 1.4 - 2) << "phase " << phase;
  }
  // Spread evenly over the logarithm of the number of images.
  for (int image = 8; image <= kImages; ++image)
    EXPECT_LE(choices[image], kPatches * (1.2 * std::log(image / (image - 1.0)) / std::log(1.4) + 0.02)) << image;
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
