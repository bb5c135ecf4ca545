// SPDX-License-Identifier: Apache-2.0
// The paper's interpolation, imputation, visibility and guidance, kept to compare with.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "reconstructor/models/surface_light_field/capture_guidance.h"
#include "reconstructor/models/surface_light_field/next_view.h"
#include "reconstructor/models/surface_light_field/patch_model.h"
#include "reconstructor/radiance/resampling.h"
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

TEST(PapersWays, ByVerticesASurfaceIsReadAtItsEdgeAsTheImageIs) {
  // Of the square, from above: its left edge is at pixel 29.5, and what the picture shows up to pixel 30 is white.
  const Object object = square_object();
  const analytic::Scene scene{analytic::square(0.2, 0), [](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
                                return Eigen::Vector3d::Constant(p.cwiseAbs().maxCoeff() > 0.098 ? 1 : 0).eval();
                              }};
  const Eigen::Vector3d eye(0, 0, 0.5);
  const Capture capture = analytic::capture(scene, camera_at(eye), analytic::towards_origin(eye));
  const MapLayout maps(std::vector<std::uint8_t>(object.mesh->triangles.size(), 4));
  const auto read = [&](VisibilityTest test) {
    SampleVisibility visibility(*object.mesh, maps, {.test = test});
    RadianceImage image;
    image.load(capture, visibility.look(capture.camera, capture.pose.camera_from_object, {}));
    return image.sample({30.6f, 59.5f}, 1, Sampling::kLinear).x();
  };
  EXPECT_NEAR(read(VisibilityTest::kVertices), 0.4, 1e-3) << "between pixel 30, white, and pixel 31, black";
  EXPECT_NEAR(read(VisibilityTest::kSamples), 0, 1e-3) << "pixel 30 touches the edge";
}

/// A model of a sphere that some images show, and that is judged by this method.
std::shared_ptr<const SurfaceLightFieldSnapshot> judged_by(GuidanceMethod method) {
  const Object object = sphere_object();
  SurfaceLightFieldOptions options = plain_options();
  options.guidance = method;
  SurfaceLightField model(object.mesh, options);
  ingest_all(model, captures({object.surface, analytic::two_terms(0.03)}, eyes(14, 0.5, 0.2)));
  return model.light_field_snapshot();
}

/// Psi_p and Psi_h of a vertex from an eye, calculated anew: the Delaunay triangle is the one whose circumcircle is
/// empty.
struct Psi {
  double projection = 1, hemisphere = 1;
  bool seen = false;

  static double of(double projection, double hemisphere) {
    return std::sqrt((projection * projection + hemisphere * hemisphere) / 2);
  }
};
Psi psi_at(const LightFieldSnapshot& model, std::size_t vertex, const Eigen::Vector3d& eye) {
  const SeenVertex* from = model.seen_vertex(vertex);
  if (!from) return {};
  const auto on_map = [&](const Eigen::Vector3d& direction) -> Eigen::Vector2d {
    const Eigen::Vector3d local = from->views->frame.cast<double>() * direction;
    return local.z() >= 0 ? local.head<2>().eval() : local.head<2>().normalized().eval();
  };
  std::vector<Eigen::Vector2d> points{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (Eigen::Index j = 0; j < from->views->directions.cols(); ++j)
    points.push_back(on_map(from->views->directions.col(j).cast<double>()));
  const Eigen::Vector2d at = on_map((eye - model.mesh().vertices[vertex].cast<double>()).normalized());
  const auto twice_area = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  };
  Psi psi{std::min(1.0, from->residual / 0.25), 1, true};
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < points.size(); ++j)
      for (std::size_t k = i + 1; k < points.size(); ++k) {
        const Eigen::Vector2d &a = points[i], &b = points[j], &c = points[k];
        if (j <= i || j == k || twice_area(a, b, c) <= 0) continue;
        if (twice_area(a, b, at) < 0 || twice_area(b, c, at) < 0 || twice_area(c, a, at) < 0) continue;
        Eigen::Matrix2d sides;
        sides << (b - a).transpose(), (c - a).transpose();
        const Eigen::Vector2d centre =
            a + sides.inverse() * Eigen::Vector2d((b - a).squaredNorm(), (c - a).squaredNorm()) / 2;
        const double radius = (a - centre).norm();
        if (std::all_of(points.begin(), points.end(),
                        [&](const Eigen::Vector2d& p) { return (p - centre).norm() > radius - 1e-6; }))
          psi.hemisphere = std::min(1.0, twice_area(a, b, c) / 2 / 0.25);
      }
  return psi;
}

TEST(PapersWays, TheImageWhosePicturesMeanHeuristicIsHighestComesFirst) {
  const auto model = judged_by(GuidanceMethod::kPaperHeuristic);
  const std::vector<Eigen::Vector3f> normals = vertex_normals(model->mesh());
  const std::vector<Eigen::Vector3d> places = eyes(12, 0.6, 0.05);
  std::vector<double> expected;
  for (const Eigen::Vector3d& eye : places) {
    double sum = 0, weight = 0;
    for (std::size_t v = 0; v < normals.size(); ++v) {
      const Eigen::Vector3d to_eye = (eye - model->mesh().vertices[v].cast<double>()).normalized();
      const double facing = normals[v].cast<double>().dot(to_eye);
      if (facing < 0.2) continue;
      const Psi psi = psi_at(*model, v, eye);
      sum += facing * Psi::of(psi.projection, psi.hemisphere);
      weight += facing;
    }
    expected.push_back(sum / weight);
  }
  const std::vector<double> worth = make_guidance(*model)->worth(places);
  ASSERT_EQ(worth.size(), expected.size());
  for (std::size_t i = 0; i < worth.size(); ++i) EXPECT_NEAR(worth[i], expected[i], 2e-3) << i;
  const auto order = [](const std::vector<double>& by) {
    std::vector<std::size_t> first(by.size());
    std::iota(first.begin(), first.end(), std::size_t{0});
    std::sort(first.begin(), first.end(), [&](std::size_t a, std::size_t b) { return by[a] > by[b]; });
    return first;
  };
  EXPECT_EQ(order(worth), order(expected));
  EXPECT_NE(order(worth), order(make_guidance(*judged_by(GuidanceMethod::kExpectedError))->worth(places)));
}

TEST(PapersWays, WhatIsRedIsThePapersHeuristicAndNothingElseChanges) {
  const auto model = judged_by(GuidanceMethod::kPaperHeuristic), own = judged_by(GuidanceMethod::kExpectedError);
  const Eigen::Vector3d eye(0.3, -0.2, 0.4);
  const std::vector<SurfaceQuality> red = model->quality_for(eye), usual = own->quality_for(eye);
  const Mesh& mesh = model->mesh();
  int alike = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_EQ(red[t].error, usual[t].error);
    EXPECT_EQ(red[t].seen, usual[t].seen);
    if (!red[t].seen) continue;
    double projection = 0, hemisphere = 0;
    for (const std::uint32_t v : mesh.triangles[t]) {
      const Psi psi = psi_at(*model, v, eye);
      projection += psi.projection / 3;
      hemisphere += psi.hemisphere / 3;
    }
    alike += std::abs(red[t].heuristic() - Psi::of(projection, hemisphere)) < 2e-3;
  }
  // Where a direction falls onto a side of a triangle of the map, the last digits decide.
  const auto seen = std::count_if(red.begin(), red.end(), [](const SurfaceQuality& q) { return q.seen; });
  EXPECT_GT(seen, 200);
  EXPECT_GE(alike, 0.99 * static_cast<double>(seen));
}

TEST(PapersWays, TheAdvicesPlaceIsWhereTheMeanHeuristicIsHigh) {
  const auto model = judged_by(GuidanceMethod::kPaperHeuristic);
  const ViewAdvice advice = model->advise_next_view({0.3, 0, 0.4});
  std::vector<Eigen::Vector3d> others = eyes(60, 0.5, 0.15, 0.97);
  std::vector<double> worth = make_guidance(*model)->worth(others);
  std::sort(worth.begin(), worth.end());
  EXPECT_GT(make_guidance(*model)->worth(std::array{advice.eye})[0], worth[worth.size() * 9 / 10]);
  EXPECT_NEAR(advice.heuristic, make_guidance(*model)->worth(std::array{advice.eye})[0], 0.05);
}

}  // namespace
}  // namespace sheen
