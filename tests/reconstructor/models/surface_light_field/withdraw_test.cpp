// SPDX-License-Identifier: Apache-2.0
// An image that is taken out of a finished model, against a model that never saw it.
#include <gtest/gtest.h>

#include "common/image/linear_reader.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5, kLowest = 0.55;

/// As if a green hand had covered the lens.
void spoil(Capture& capture) {
  ImageF pixels = to_linear_rgb(capture.image);
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x)
      Eigen::Map<Eigen::Vector3f>(pixels.pixel(x, y)) = Eigen::Vector3f(0, 0.9, 0);
  capture.image = analytic::float_image(pixels);
}

class Withdraw : public ::testing::Test {
 protected:
  /// Of maps that stay, so that models can be compared sample by sample (others: map_detail_test.cpp).
  static SurfaceLightFieldOptions on_the_same_maps() {
    SurfaceLightFieldOptions options = plain_options();
    options.map_detail = 0;
    return options;
  }

  /// Image `k` of `count` is spoilt, folded in and taken out: error over that of a model that never saw it.
  double error_ratio(int count, int k, const SurfaceLightFieldOptions& options = on_the_same_maps()) {
    std::vector<Capture> images = captures(scene_, eyes(count, kDistance, kLowest));
    spoil(images[k]);
    SurfaceLightField model(object_.mesh, options), never(object_.mesh, options);
    ingest_all(model, images);
    const double spoilt = compare(*model.snapshot(), scene_, unseen_eyes()).rms;
    EXPECT_TRUE(model.withdraw(images[k]));
    EXPECT_FALSE(model.withdraw(images[k])) << "it is gone";
    images.erase(images.begin() + k);
    ingest_all(never, images);
    EXPECT_EQ(model.figures().images, never.figures().images);
    expect_same_views(*model.light_field_snapshot(), *never.light_field_snapshot());
    EXPECT_NEAR(compare(*model.constant_colour(), scene_, unseen_eyes()).rms /
                    compare(*never.constant_colour(), scene_, unseen_eyes()).rms,
                1, 1e-4);
    const double error = compare(*never.snapshot(), scene_, unseen_eyes()).rms;
    EXPECT_GT(spoilt, 1.5 * error) << "it was worth taking out";
    const double ratio = compare(*model.snapshot(), scene_, unseen_eyes()).rms / error;
    std::printf("image %d of %d: error with it %.3f times that without, after taking it out %.5f times\n", k, count,
                spoilt / error, ratio);
    return ratio;
  }

  static void expect_same_views(const SurfaceLightFieldSnapshot& a, const SurfaceLightFieldSnapshot& b) {
    for (std::size_t i = 0; i < a.patches().size(); ++i) {
      if (!a.patches()[i] && !b.patches()[i]) continue;
      ASSERT_TRUE(a.patches()[i] && b.patches()[i]) << i;
      EXPECT_EQ(a.patches()[i]->shown, b.patches()[i]->shown);
      for (std::size_t k = 0; k < a.patches()[i]->vertices.size(); ++k) {
        const VertexInterpolant &v = a.patches()[i]->vertices[k], &w = b.patches()[i]->vertices[k];
        EXPECT_EQ(v.views_folded, w.views_folded);
        EXPECT_EQ(v.views->directions.cols(), w.views->directions.cols());
      }
    }
  }

  const Object object_ = square_object();
  const Scene scene_{object_.surface, analytic::two_terms(0.1)};
};

TEST_F(Withdraw, TheErrorIsThatOfAModelThatNeverSawTheImage) {
  for (const int k : {17, 38, 39}) EXPECT_LE(error_ratio(40, k), 1.005) << k;
  // The second image was half of all that the model then knew, and the others were imputed with it.
  EXPECT_LE(error_ratio(40, 1), 1.15);
}

TEST_F(Withdraw, AnImageThatWasMergedWithOthersIsTakenOutOfThem) {
  SurfaceLightFieldOptions options = plain_options();
  options.patch.max_views = 24;
  std::vector<Capture> images = captures(scene_, eyes(40, kDistance, kLowest));
  spoil(images[9]);
  SurfaceLightField model(object_.mesh, options), never(object_.mesh, options);
  ingest_all(model, images);
  const double spoilt = compare(*model.snapshot(), scene_, unseen_eyes()).rms;
  ASSERT_TRUE(model.withdraw(images[9]));
  images.erase(images.begin() + 9);
  ingest_all(never, images);
  const double error = compare(*never.snapshot(), scene_, unseen_eyes()).rms;
  std::printf("merged: with it %.3f, after taking it out %.5f\n", spoilt / error,
              compare(*model.snapshot(), scene_, unseen_eyes()).rms / error);
  EXPECT_LT(compare(*model.snapshot(), scene_, unseen_eyes()).rms, 1.05 * error);
}

TEST_F(Withdraw, OfTheFirstImageAndOfUnknownOnesTheModelSaysThatItCannot) {
  std::vector<Capture> images = captures(scene_, eyes(4, kDistance, kLowest));
  SurfaceLightField model(object_.mesh, plain_options());
  EXPECT_FALSE(model.withdraw(images[0])) << "nothing is there yet";
  ingest_all(model, {images[0], images[1]});
  EXPECT_FALSE(model.withdraw(images[0])) << "maps and exposure come from it";
  EXPECT_FALSE(model.withdraw(images[2]));
  EXPECT_TRUE(model.withdraw(images[1]));
  EXPECT_EQ(model.figures().images, 1u);
}

}  // namespace
}  // namespace sheen
