// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "reconstructor/models/surface_light_field/next_view.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5;

double mean_heuristic(const ModelSnapshot& model, const Eigen::Vector3d& eye) {
  const auto shader = model.shader_for(eye);
  const std::size_t triangles = model.mesh().triangles.size();
  double sum = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) sum += shader->heuristic(t);
  return sum / static_cast<double>(triangles);
}

double share_of(const ModelSnapshot& model, const Eigen::Vector3d& eye, QualityReason reason) {
  const auto shader = model.shader_for(eye);
  const std::size_t triangles = model.mesh().triangles.size();
  int count = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) count += shader->reason(t) == reason;
  return static_cast<double>(count) / static_cast<double>(triangles);
}

TEST(Quality, TheHeuristicIsTheRootOfTheMeanOfBothSquares) {
  EXPECT_EQ(RingQuality{}.heuristic(), 1);
  EXPECT_EQ((RingQuality{.seen = false, .projection = 0, .hemisphere = 0}.heuristic()), 1)
      << "what is unseen is unknown";
  EXPECT_EQ((RingQuality{.seen = true, .projection = 0, .hemisphere = 0}.heuristic()), 0);
  EXPECT_NEAR((RingQuality{.seen = true, .projection = 0.6f, .hemisphere = 0.8f}.heuristic()), std::sqrt(0.5), 1e-6);
  EXPECT_NEAR((RingQuality{.seen = true, .projection = 1, .hemisphere = 1}.heuristic()), 1, 1e-6);
}

TEST(Quality, TheReasonIsTheWorstThatHolds) {
  EXPECT_EQ(RingQuality{}.reason(), QualityReason::kUnseen);
  EXPECT_EQ((RingQuality{true, 0.9f, 0.2f, 0.9f}.reason()), QualityReason::kHighResidual);
  EXPECT_EQ((RingQuality{true, 0.2f, 0.9f, 0.9f}.reason()), QualityReason::kSparseDirections);
  EXPECT_EQ((RingQuality{true, 0.1f, 0.1f, 0.9f}.reason()), QualityReason::kGood);
  EXPECT_EQ((RingQuality{true, 0.1f, 0.1f, 0.2f}.reason()), QualityReason::kOblique);
}

TEST(Quality, ATriangleIsKnownAsTheMeanOfItsRingsAndUnseenWithAnyOfThem) {
  const RingQuality a{true, 0.3f, 0.6f, 0.5f}, b{true, 0.6f, 0, 0.9f}, c{true, 0, 0.3f, 0.1f};
  const RingQuality mean = combine(a, b, c);
  EXPECT_TRUE(mean.seen);
  EXPECT_NEAR(mean.projection, 0.3f, 1e-6);
  EXPECT_NEAR(mean.hemisphere, 0.3f, 1e-6);
  EXPECT_EQ(mean.best_cosine, 0.9f);
  EXPECT_EQ(combine(a, RingQuality{}, c).heuristic(), 1);
}

TEST(Quality, ARingIsJudgedByItsResidualAndTheViewsRoundTheDirection) {
  RingSnapshot ring;
  ring.frame = hemisphere_frame(Eigen::Vector3f::UnitZ());
  EXPECT_EQ(assess_ring(ring, Eigen::Vector3f::UnitZ()).heuristic(), 1) << "a ring without a basis is unseen";
  ring.basis = Eigen::MatrixXf::Ones(3, 1);
  ring.residual = 0.05f;
  ring.best_cosine = 0.8f;
  // Three views close round the normal, and nothing elsewhere: a small triangle on the map, and large ones.
  ring.directions.resize(3, 3);
  for (int j = 0; j < 3; ++j) {
    const float angle = 2.0f * j;
    ring.directions.col(j) = Eigen::Vector3f(0.2f * std::cos(angle), 0.2f * std::sin(angle), 1).normalized();
  }
  ring.views = triangulate_views(ring.frame, ring.directions);
  const RingQuality near = assess_ring(ring, Eigen::Vector3f::UnitZ());
  const RingQuality far = assess_ring(ring, Eigen::Vector3f(0.9f, 0, 0.4f).normalized());
  EXPECT_TRUE(near.seen && far.seen);
  EXPECT_NEAR(near.projection, 0.2f, 1e-5) << "a quarter of the norm counts as not known at all";
  EXPECT_EQ(near.projection, far.projection);
  const auto at = [&](int j) {
    return Eigen::Vector2d(hemisphere_point(ring.frame, ring.directions.col(j)).cast<double>());
  };
  const Eigen::Vector2d u = at(1) - at(0), v = at(2) - at(0);
  EXPECT_NEAR(near.hemisphere, 0.5 * std::abs(u.x() * v.y() - u.y() * v.x()) / 0.25, 2e-3);
  EXPECT_EQ(far.hemisphere, 1);
  EXPECT_EQ(near.best_cosine, 0.8f);
}

TEST(Quality, FallsFromOneAsImagesCome) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.2)};
  const Eigen::Vector3d eye(0.05, 0.08, 0.49);
  SurfaceLightField model(object.mesh, plain_options());
  EXPECT_EQ(mean_heuristic(*model.snapshot(), eye), 1);
  EXPECT_EQ(share_of(*model.snapshot(), eye, QualityReason::kUnseen), 1);
  std::vector<double> course;
  for (const Capture& image : captures(scene, eyes(48, kDistance, 0.5))) {
    ingest_all(model, {image});
    course.push_back(mean_heuristic(*model.snapshot(), eye));
  }
  for (const double h : course) EXPECT_LE(h, 1);
  EXPECT_GT(course[0], 0.7) << "one image is not enough";
  EXPECT_LT(course[11], course[0]);
  EXPECT_LT(course[47], 0.5 * course[11]);
  EXPECT_LT(course[47], 0.25);
  EXPECT_GT(share_of(*model.snapshot(), eye, QualityReason::kGood), 0.95);
  EXPECT_GT(mean_heuristic(*model.snapshot(), {0.49, 0, 0.05}), 1.5 * course[47]) << "where no image was taken from";
}

TEST(Quality, SurfaceSeenOnlyAtGrazingAnglesSaysSo) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  SurfaceLightField model(object.mesh, plain_options());
  std::vector<Eigen::Vector3d> low;
  for (int i = 0; i < 12; ++i)
    low.push_back(kDistance * Eigen::Vector3d(std::cos(0.52 * i), std::sin(0.52 * i), 0.25).normalized());
  ingest_all(model, captures(scene, low));
  EXPECT_GT(share_of(*model.snapshot(), {0, 0, 0.5}, QualityReason::kOblique), 0.5);
}

TEST(Quality, ImagesThatKeepContradictingTheModelSaySo) {
  const Object object = square_object();
  SurfaceLightField model(object.mesh, plain_options());
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> phase(0, 100);
  for (const Eigen::Vector3d& eye : eyes(40, kDistance, 0.6)) {
    const Eigen::Vector3d shift(phase(engine), phase(engine), phase(engine));
    const Scene another{object.surface, analytic::encoded([&](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
                          return Eigen::Vector3d(3 * (analytic::waves(p + shift, 0.02).array() - 0.5) + 0.5);
                        })};
    model.ingest(analytic::capture(another, camera_at(eye), analytic::towards_origin(eye)));
  }
  EXPECT_GT(share_of(*model.snapshot(), {0.01, 0.02, 0.5}, QualityReason::kHighResidual), 0.5);
}

TEST(NextView, PointsToTheSideThatNoImageShows) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  std::vector<Eigen::Vector3d> half;
  for (const Eigen::Vector3d& eye : eyes(80, kDistance, 0.05))
    if (eye.x() > 0.1) half.push_back(eye);
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, half));
  const Eigen::Vector3d eye(0.35, 0.1, 0.3);
  const ViewAdvice advice = advise_next_view(*model.light_field_snapshot(), eye);
  EXPECT_LT(advice.eye.x(), -0.25);
  EXPECT_GT(advice.eye.z(), 0) << "above the stage";
  EXPECT_NEAR(advice.eye.norm(), eye.norm(), 1e-3) << "as far from the object as now";
  EXPECT_GT(advice.heuristic, 0.8);
  EXPECT_NEAR(advice.turn_deg, std::acos(eye.normalized().dot(advice.eye.normalized())) * 180 / M_PI, 0.01);
  EXPECT_THAT(advice.reason, testing::HasSubstr("not seen"));
}

TEST(NextView, SaysWhenAllIsCoveredAndBeforeAnythingIs) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  SurfaceLightField model(object.mesh, plain_options());
  const ViewAdvice first = advise_next_view(*model.light_field_snapshot(), {0.3, 0, 0.4});
  EXPECT_EQ(first.heuristic, 1);
  EXPECT_THAT(first.reason, testing::HasSubstr("not seen"));
  ingest_all(model, captures(scene, eyes(120, kDistance, -0.3)));
  const ViewAdvice last = advise_next_view(*model.light_field_snapshot(), {0.3, 0, 0.4});
  EXPECT_LT(last.heuristic, 0.35);
  EXPECT_GT(last.heuristic, 0);
  EXPECT_TRUE(last.eye.allFinite());
}

}  // namespace
}  // namespace sheen
