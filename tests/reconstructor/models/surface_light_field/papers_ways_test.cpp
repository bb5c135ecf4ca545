// SPDX-License-Identifier: Apache-2.0
// The paper's interpolation and imputation, kept to compare with.
#include <gtest/gtest.h>

#include <array>

#include <algorithm>

#include "reconstructor/models/surface_light_field/patch_model.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using analytic::eyes;

const MapSides kSides{4, 4};
constexpr int kSamples = 20;

struct Stream {
  PatchModel patch{kSides, 1, {}, {.factor = {.max_rank = 4, .tolerance = 0, .imputation = Imputation::kLeastSquares}}};
  Eigen::MatrixXf columns = patch_like_matrix(3 * kSamples, 40, 3, 0.01f, 1);
  int next = 0;

  /// Whether the next image, which shows so many samples, was used.
  bool takes(int shown) {
    std::vector<std::uint8_t> visible(kSamples, 0);
    std::fill_n(visible.begin(), shown, 1);
    const float angle = 0.05f * static_cast<float>(next);
    const Eigen::Vector3f direction(std::sin(angle), 0, std::cos(angle));
    return patch.absorb(columns.col(next++), visible, direction, std::array{std::cos(angle)}).used;
  }
};

TEST(PapersWays, HalfOfAPatchMustBeVisibleAndNineImagesShowAllOfItFirst) {
  Stream stream;
  for (int i = 0; i < 8; ++i) {
    EXPECT_FALSE(stream.takes(kSamples - 1)) << "too early, after " << i;
    EXPECT_TRUE(stream.takes(kSamples));
  }
  EXPECT_FALSE(stream.takes(kSamples - 1));
  EXPECT_TRUE(stream.takes(kSamples));
  EXPECT_TRUE(stream.takes(kSamples / 2));
  EXPECT_FALSE(stream.takes(kSamples / 2 - 1));
}

TEST(PapersWays, ImagesThatHideSamplesCountAsMuchAsOthers) {
  EXPECT_EQ(image_weight({.imputation = Imputation::kLeastSquares}, 0.5), 1);
  EXPECT_EQ(image_weight({}, 0.5), 0.25);
}

TEST(PapersWays, DelaunayPassesThroughTheViewsAndIsLinearBetweenThem) {
  const Object object = square_object();
  const std::vector<Eigen::Vector3d> from = eyes(25, 0.5, 0.55);
  SurfaceLightFieldOptions options = plain_options();
  options.patch.factor = {.max_rank = 6, .tolerance = 0};
  options.patch.interpolation.method = ViewMethod::kDelaunay;
  SurfaceLightField model(object.mesh, options);
  ingest_all(model, captures({object.surface, analytic::two_terms(0.2)}, from));
  const auto snapshot = model.light_field_snapshot();
  const std::size_t middle = 9 * 4 + 4;
  const VertexInterpolant& vertex = *snapshot->seen_at(middle);
  ASSERT_TRUE(vertex.triangulation);
  const Eigen::MatrixXf coefficients = vertex.weights.unpacked().transpose();
  for (int j = 0; j < 25; ++j)
    EXPECT_LT((vertex.coefficients(vertex.views->directions.col(j)) - coefficients.col(j)).norm(),
              0.02 * coefficients.norm() / 5)
        << j;
  int inside = 0;
  for (const auto& corners : vertex.triangulation->triangles) {
    if (std::any_of(corners.begin(), corners.end(), [](int p) { return p < ViewTriangulation::kCorners; })) continue;
    ++inside;
    Eigen::Vector2f place = Eigen::Vector2f::Zero();
    Eigen::VectorXf mean = Eigen::VectorXf::Zero(coefficients.rows());
    for (const int p : corners) {
      place += vertex.triangulation->points.col(p) / 3;
      mean += coefficients.col(p - ViewTriangulation::kCorners) / 3;
    }
    const Eigen::Vector3f local(place.x(), place.y(), std::sqrt(1 - place.squaredNorm()));
    EXPECT_LT((vertex.coefficients(vertex.views->frame.transpose() * local) - mean).norm(), 1e-3 * mean.norm());
  }
  EXPECT_GT(inside, 10);
}

TEST(PapersWays, WithoutTheDriftNoVertexHasOne) {
  const Object object = sphere_object();
  const std::vector<Capture> images = captures({object.surface, analytic::two_terms(0.2)}, eyes(20, 0.5, 0.2));
  for (const bool drift : {true, false}) {
    SurfaceLightFieldOptions options = plain_options();
    options.patch.interpolation.drift = drift;
    SurfaceLightField model(object.mesh, options);
    ingest_all(model, images);
    const auto snapshot = model.light_field_snapshot();
    int with = 0;
    for (std::size_t v = 0; v < object.mesh->vertices.size(); ++v)
      if (const VertexInterpolant* at = snapshot->seen_at(v)) with += at->views->reflection != nullptr;
    EXPECT_EQ(with > 0, drift);
  }
}

TEST(PapersWays, WithoutExponentialKernelsNoVertexHasOne) {
  const Object object = sphere_object();
  const std::vector<Capture> images = captures({object.surface, analytic::two_terms(0.2)}, eyes(20, 0.5, 0.2));
  SurfaceLightFieldOptions options = plain_options();
  options.patch.interpolation.exponential = false;
  SurfaceLightField model(object.mesh, options);
  ingest_all(model, images);
  const auto snapshot = model.light_field_snapshot();
  int vertices = 0;
  for (const auto& patch : snapshot->patches()) {
    if (!patch) continue;
    for (const VertexInterpolant& vertex : patch->vertices) {
      ++vertices;
      EXPECT_EQ(vertex.views->kernel.shape, KernelShape::kMatern);
    }
  }
  EXPECT_GT(vertices, 100);
}

}  // namespace
}  // namespace sheen
