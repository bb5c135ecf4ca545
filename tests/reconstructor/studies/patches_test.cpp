// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/patches.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

/// The same surface with vertices of its own for every triangle.
Mesh split_triangles(const Mesh& mesh) {
  Mesh split;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) split.vertices.push_back(mesh.corner(t, c));
    split.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return split;
}

/// Pictures of `columns` wide bands of one error each, two pixels high, over a truth of 100.
struct Bands {
  Mesh mesh = square_mesh(1, 0, 1);  // two triangles with an edge in common
  std::vector<std::uint32_t> triangle;
  ImageU8 picture, truth, object;

  Bands(std::vector<std::uint32_t> shown, std::vector<int> error)
      : triangle(std::move(shown)),
        picture(static_cast<int>(error.size()), 2, 3),
        truth(static_cast<int>(error.size()), 2, 3),
        object(static_cast<int>(error.size()), 2, 1) {
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < picture.width(); ++x) {
        object.at(x, y) = 255;
        for (int c = 0; c < 3; ++c) {
          truth.at(x, y, c) = 100;
          picture.at(x, y, c) = static_cast<std::uint8_t>(100 + error[static_cast<std::size_t>(x)]);
        }
      }
  }
  SeamError seams() const {
    std::vector<Hit> hits;
    for (int y = 0; y < 2; ++y)
      for (const std::uint32_t t : triangle) hits.push_back({.triangle = t, .front = true});
    return seam_error(mesh, hits, picture, truth, object);
  }
};

TEST(SeamError, IsTheRatioOfRootMeanSquares) {
  // Changes of 2, 10 and -2 from band to band and none down: within, 16 squared over 8 pairs; across, 200 over 2.
  const SeamError seams = Bands({0, 0, 1, 1}, {0, 2, 12, 10}).seams();
  EXPECT_EQ(seams.within, 3u * 8);
  EXPECT_EQ(seams.across, 3u * 2);
  EXPECT_EQ(seams.within2, 3.0 * 16);
  EXPECT_EQ(seams.across2, 3.0 * 200);
  EXPECT_DOUBLE_EQ(seams.ratio(), std::sqrt(100.0 / 2.0));
}

TEST(SeamError, TellsAStepAtTheEdgeFromOneInside) {
  EXPECT_GT(Bands({0, 0, 0, 1, 1, 1}, {0, 1, 0, 9, 8, 9}).seams().ratio(), 5);
  EXPECT_LT(Bands({0, 0, 0, 1, 1, 1}, {0, 9, 8, 9, 0, 1}).seams().ratio(), 0.5);
}

TEST(SeamError, IsDefinedWithoutChanges) {
  EXPECT_EQ(Bands({0, 0, 1, 1}, {7, 7, 7, 7}).seams().ratio(), 1);
  EXPECT_EQ(Bands({0, 0, 1, 1}, {0, 0, 7, 7}).seams().ratio(), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(Bands({0, 0, 0, 0}, {0, 3, 0, 3}).seams().ratio())) << "no edge in sight";
  EXPECT_TRUE(std::isnan(SeamError().ratio()));
}

TEST(SeamError, ATextureThatThePictureHasTooIsNoSeam) {
  Bands bands({0, 0, 1, 1}, {0, 2, 4, 6});
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) {
        const std::uint8_t texture = x < 2 ? 0 : 90;
        bands.truth.at(x, y, c) = static_cast<std::uint8_t>(bands.truth.at(x, y, c) + texture);
        bands.picture.at(x, y, c) = static_cast<std::uint8_t>(bands.picture.at(x, y, c) + texture);
      }
  EXPECT_DOUBLE_EQ(bands.seams().ratio(), std::sqrt(4.0 / (4.0 * 4 / 8)));
}

TEST(SeamError, CountsNeitherStepsInDepthNorWhatIsNotTheObject) {
  Bands bands({0, 0, 1, 1}, {0, 2, 12, 10});
  bands.mesh = joined(square_mesh(1, 0, 1), square_mesh(1, -1, 1));
  bands.triangle = {0, 0, 2, 2};
  EXPECT_EQ(bands.seams().across, 0u) << "triangles that do not touch";
  EXPECT_EQ(bands.seams().within, 3u * 8);
  bands.triangle = {0, kNoHit, kNoHit, 1};
  EXPECT_EQ(bands.seams().across, 0u);
  EXPECT_EQ(bands.seams().within, 3u * 2) << "the first band and the last, each down";
  bands.triangle = {0, 0, 1, 1};
  for (int y = 0; y < 2; ++y) bands.object.at(2, y) = 0;
  EXPECT_EQ(bands.seams().across, 0u);
  EXPECT_EQ(bands.seams().within, 3u * 5);
}

TEST(SeamError, GoesByPlacesNotByVertices) {
  Bands bands({0, 0, 1, 1}, {0, 2, 12, 10});
  const double ratio = bands.seams().ratio();
  bands.mesh = split_triangles(bands.mesh);
  EXPECT_EQ(bands.seams().ratio(), ratio);
}

TEST(PatchStudy, PatchesOfAllSizesReproduceADiffuseSquareAlike) {
  const std::vector<Capture> all =
      captures({square_object().surface, analytic::diffuse(0.2)}, analytic::eyes(24, 0.5, 0.55));
  const Experiment experiment =
      load_experiment(square_object().mesh, all.size(), [&](std::size_t i) { return all[i]; }, {});
  const std::vector<PatchRow> rows = study_patches(experiment, plain_options(), std::array{1, 2, 4});
  ASSERT_EQ(rows.size(), 3u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].triangles, 1 << i);
    EXPECT_NEAR(static_cast<double>(rows[i].patches), 128 >> i, 16 >> i) << "8x8 cells of two triangles";
    EXPECT_GT(rows[i].psnr_db, 55);
    EXPECT_NEAR(rows[i].psnr_db, rows[0].psnr_db, 1);
    EXPECT_NEAR(rows[i].ssim, rows[0].ssim, 1e-3);
    EXPECT_GT(rows[i].factorize_ms, 0);
    EXPECT_NEAR(rows[i].seam, rows[0].seam, 0.1) << "where nothing is lost there is no seam";
  }
  EXPECT_GT(rows[1].bytes, 0);
  EXPECT_LT(rows[1].bytes, rows[0].bytes) << "what a factor holds beside its rows is there half as often";
  EXPECT_LT(rows[2].bytes, rows[1].bytes);
}

}  // namespace
}  // namespace sheen
