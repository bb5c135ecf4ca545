// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/batch_light_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

SurfaceLightFieldOptions exact_options(int rank) {
  SurfaceLightFieldOptions options = plain_options();
  options.patch.factor = {.max_rank = rank, .tolerance = 0};
  options.map_detail = 0;  // the batch has the maps of the first image
  return options;
}

struct Pair {
  std::shared_ptr<const SurfaceLightFieldSnapshot> online, batch;
};

Pair build_both(const Object& object, const std::vector<Capture>& images, int rank) {
  SurfaceLightField online(object.mesh, exact_options(rank));
  ingest_all(online, images);
  BatchLightField batch(object.mesh, exact_options(rank));
  for (const Capture& image : images) batch.add(image);
  return {online.light_field_snapshot(),
          batch.factorize(BatchFactorization::reference(exact_options(rank).patch.factor))};
}

TEST(BatchLightField, IsTheOnlineOneWhereNothingIsMissingAndTheRankIsFull) {
  const Object object = square_object();
  const auto [online, batch] =
      build_both(object, captures({object.surface, analytic::two_terms(0.2)}, eyes(5, 0.5, 0.55)), 5);
  // As many as a kernel takes, and too few for the drift, which the online one estimates now and then only.
  int same_kernel = 0, vertices = 0;
  for (std::size_t p = 0; p < online->patches().size(); ++p) {
    const auto away_from_the_rim = [](std::uint32_t v) {
      return std::min(v % 9, v / 9) >= 2 && std::max(v % 9, v / 9) <= 6;
    };
    const auto of_patch = online->shapes().patches[p].vertices;
    if (!std::all_of(of_patch.begin(), of_patch.end(), away_from_the_rim)) continue;  // all images show all of it
    const PatchSnapshot &a = *online->patches()[p], &b = *batch->patches()[p];
    for (std::size_t i = 0; i < of_patch.size(); ++i) {
      ++vertices;
      if (!(a.vertices[i].views->kernel == b.vertices[i].views->kernel)) continue;
      ++same_kernel;
      for (const Eigen::Vector3d& eye : eyes(4, 0.5, 0.63, 0.95)) {
        const Eigen::Vector3f direction = (eye.cast<float>() - object.mesh->vertices[of_patch[i]]).normalized();
        const Eigen::VectorXf difference =
            a.colours() * a.vertices[i].coefficients(direction) - b.colours() * b.vertices[i].coefficients(direction);
        EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-4) << "patch " << p << ", vertex " << of_patch[i];
      }
    }
  }
  EXPECT_GT(vertices, 60);
  EXPECT_GT(same_kernel, 0.8 * vertices);
}

TEST(BatchLightField, FillsWhatSomeImagesDoNotShow) {
  const Object ball{std::make_shared<Mesh>(sphere_mesh(0.09f, 2)), analytic::sphere(0.09)};
  const Scene scene{ball.surface, analytic::diffuse(0.2)};
  const std::vector<Capture> images = captures(scene, eyes(16, 0.5, 0.2));
  BatchLightField batch(ball.mesh, exact_options(2));
  for (const Capture& image : images) batch.add(image);
  double shown = 0, filled = 0;
  int holes = 0;
  for (std::size_t p = 0; p < batch.patches(); ++p) {
    const PatchMatrix patch = batch.patch(p);
    if (patch.views() < 4 || (patch.known != 0).all() || !(patch.known != 0).rowwise().any().all()) continue;
    const BatchPca pca = batch_pca_missing(patch.columns, patch.known, 1, {}, BatchFactorization::quick(1).missing);
    // A diffuse row has one value: what is filled in must be what other images show of the row.
    const Eigen::MatrixXf model = (pca.basis * pca.coefficients).cast<float>();
    for (Eigen::Index i = 0; i < model.rows(); ++i) {
      const float value = patch.columns.row(i).sum() / static_cast<float>((patch.known.row(i) != 0).count());
      for (Eigen::Index j = 0; j < model.cols(); ++j) {
        double& worst = patch.known(i, j) ? shown : filled;
        worst = std::max(worst, static_cast<double>(std::abs(model(i, j) - value)));
        holes += !patch.known(i, j);
      }
    }
  }
  EXPECT_GT(holes, 1000);
  EXPECT_LT(filled, 2 * shown + 0.02);
  EXPECT_GT(compare(*batch.factorize(BatchFactorization::quick(1)), scene, eyes(3, 0.5, 0.4, 0.9)).psnr_db(), 35);
}

TEST(BatchLightField, KeepsEveryColumn) {
  const Object object = square_object();
  const std::vector<Capture> images = captures({object.surface, analytic::diffuse(0.06)}, eyes(5, 0.5, 0.55));
  BatchLightField batch(object.mesh, exact_options(3));
  std::size_t before = 0;
  for (const Capture& image : images) {
    batch.add(image);
    EXPECT_GT(batch.bytes(), before);
    before = batch.bytes();
  }
  EXPECT_EQ(batch.images(), 5u);
  ASSERT_EQ(batch.patches(), 64u) << "two of 128 triangles each";
  const PatchMatrix patch = batch.patch(20);
  ASSERT_EQ(patch.views(), 5);
  for (int j = 0; j < 5; ++j) {
    EXPECT_EQ(patch.images[static_cast<std::size_t>(j)], static_cast<std::uint32_t>(j));
    EXPECT_EQ(patch.fraction(j), 1.0);
    const Eigen::Vector3d eye = camera_centre(images[static_cast<std::size_t>(j)].pose.camera_from_object);
    EXPECT_LT((patch.eyes.col(j) - eye.cast<float>()).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace sheen
