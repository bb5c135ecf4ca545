// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "reconstructor/models/surface_light_field/image_worth.h"
#include "reconstructor/models/surface_light_field/next_view.h"
#include "reconstructor/surface/view_hemisphere.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5;

double mean_heuristic(const Appearance& model, const Eigen::Vector3d& eye) {
  const auto shader = model.shader_for({eye});
  const std::size_t triangles = model.mesh().triangles.size();
  double sum = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) sum += shader->quality(t).heuristic();
  return sum / static_cast<double>(triangles);
}

double share_of(const Appearance& model, const Eigen::Vector3d& eye, QualityReason reason) {
  const auto shader = model.shader_for({eye});
  const std::size_t triangles = model.mesh().triangles.size();
  int count = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) count += shader->quality(t).reason() == reason;
  return static_cast<double>(count) / static_cast<double>(triangles);
}

TEST(Quality, TheHeuristicIsTheErrorOverATenth) {
  EXPECT_EQ(SurfaceQuality{}.heuristic(), 1);
  EXPECT_EQ((SurfaceQuality{.seen = false, .error = 0}.heuristic()), 1) << "what is unseen is unknown";
  EXPECT_EQ((SurfaceQuality{.seen = true, .error = 0}.heuristic()), 0);
  EXPECT_NEAR((SurfaceQuality{.seen = true, .error = 0.03f}.heuristic()), 0.3, 1e-6);
  EXPECT_EQ((SurfaceQuality{.seen = true, .error = 0.3f}.heuristic()), 1);
}

TEST(Quality, TheReasonIsTheWorstThatHolds) {
  EXPECT_EQ(SurfaceQuality{}.reason(), QualityReason::kUnseen);
  EXPECT_EQ((SurfaceQuality{true, 0.09f, 0.99f, 0.9f}.reason()), QualityReason::kHighResidual);
  EXPECT_EQ((SurfaceQuality{true, 0.09f, 0.8f, 0.9f}.reason()), QualityReason::kSparseDirections);
  EXPECT_EQ((SurfaceQuality{true, 0.01f, 0.8f, 0.9f}.reason()), QualityReason::kGood);
  EXPECT_EQ((SurfaceQuality{true, 0.01f, 0.8f, 0.2f}.reason()), QualityReason::kOblique);
}

TEST(Quality, WhoseShapeIsAGuessNeedsImages) {
  const SurfaceQuality guessed{.seen = true, .error = 0.01f, .best_cosine = 0.9f, .shape_guessed = true};
  EXPECT_EQ(guessed.reason(), QualityReason::kShapeGuessed);
  EXPECT_EQ(guessed.heuristic(), 0.5f);
  EXPECT_EQ((SurfaceQuality{.seen = false, .shape_guessed = true}.reason()), QualityReason::kUnseen);
  SurfaceQuality known = guessed;
  known.shape_guessed = false;
  EXPECT_TRUE(combine(guessed, guessed, known).shape_guessed);
  EXPECT_FALSE(combine(guessed, known, known).shape_guessed);
}

TEST(Quality, ATriangleIsKnownAsTheMeanOfItsVerticesAndUnseenWithAnyOfThem) {
  const SurfaceQuality a{true, 0.03f, 0.6f, 0.5f}, b{true, 0.06f, 0.9f, 0.9f}, c{true, 0, 0.3f, 0.1f};
  const SurfaceQuality mean = combine(a, b, c);
  EXPECT_TRUE(mean.seen);
  EXPECT_NEAR(mean.error, 0.03f, 1e-7);
  EXPECT_EQ(mean.nearest_cosine, 0.9f);
  EXPECT_EQ(mean.best_cosine, 0.9f);
  EXPECT_EQ(combine(a, SurfaceQuality{}, c).heuristic(), 1);
}

/// A vertex with three views close round the normal.
VertexInterpolant seen_from_three() {
  auto views = std::make_shared<VertexViews>();
  views->frame = hemisphere_frame(Eigen::Vector3f::UnitZ());
  views->best_cosine = 0.8f;
  views->kernel = kViewKernels[0];
  views->directions.resize(3, 3);
  for (int j = 0; j < 3; ++j) {
    const float angle = 2.0f * j;
    views->directions.col(j) = Eigen::Vector3f(0.2f * std::cos(angle), 0.2f * std::sin(angle), 1).normalized();
  }
  VertexInterpolant vertex;
  vertex.views = std::move(views);
  vertex.sill = 0.004f;
  return vertex;
}

TEST(Quality, TheErrorAtAVertexIsKrigings) {
  const VertexInterpolant vertex = seen_from_three();
  const auto variance = [&](const Eigen::Vector3f& direction) {
    return prediction_variance(vertex.views->directions, vertex.views->kernel, direction);
  };
  constexpr float kCommon = 0.012f;  // counts for one view beside the three
  const Eigen::Vector3f far = Eigen::Vector3f(0.9f, 0, 0.4f).normalized();
  const SurfaceQuality near = assess_vertex(vertex, Eigen::Vector3f::UnitZ(), kCommon),
                       aside = assess_vertex(vertex, far, kCommon);
  EXPECT_TRUE(near.seen && aside.seen);
  EXPECT_NEAR(near.error, std::sqrt(0.006f * variance(Eigen::Vector3f::UnitZ())), 1e-6);
  EXPECT_NEAR(aside.error, std::sqrt(0.006f * variance(far)), 1e-6);
  EXPECT_GT(aside.error, 2 * near.error) << "no image is near there";
  EXPECT_NEAR(near.nearest_cosine, 1 / std::sqrt(1.04), 1e-6);
  EXPECT_EQ(near.best_cosine, 0.8f);
}

TEST(Quality, AGuessIsUnseen) {
  PatchSnapshot patch;
  EXPECT_FALSE(patch.seen()) << "a patch without a basis";
  patch.basis = Eigen::MatrixXf(Eigen::MatrixXf::Ones(3, 1));
  patch.shown = {255};
  EXPECT_FALSE(patch.seen()) << "a patch without vertices";
  patch.vertices = {seen_from_three()};
  EXPECT_TRUE(patch.seen());
  patch.shown = {0};
  EXPECT_FALSE(patch.seen()) << "its colour is a neighbour's";
  patch.shown = {255};
  patch.vertices[0].views = std::make_shared<VertexViews>();
  EXPECT_FALSE(patch.seen()) << "a patch without views";
}

TEST(Quality, ASillWithoutBoundsIsAsBadAsCanBeAndFitsAFile) {
  VertexInterpolant vertex = seen_from_three();
  ViewInterpolant interpolant;
  interpolant.sill = 1e80;
  vertex.set_interpolation(interpolant, 1);
  EXPECT_EQ(vertex.sill, 1e6f);
  EXPECT_EQ(assess_vertex(vertex, Eigen::Vector3f::UnitZ(), vertex.sill).heuristic(), 1);
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
  // What is diffuse and was seen is known from everywhere, so that the fraction of the rest remains.
  double unseen = 0, all = 0;
  for (const Eigen::Vector3f& vertex : object.mesh->vertices) {
    const Eigen::Vector3d place = vertex.cast<double>(), normal = place.normalized();
    const auto facing = [&](const Eigen::Vector3d& from) { return normal.dot((from - place).normalized()); };
    if (facing(advice.eye) < 0.2) continue;
    all += facing(advice.eye);
    if (std::none_of(half.begin(), half.end(), [&](const Eigen::Vector3d& from) { return facing(from) > 0.1; }))
      unseen += facing(advice.eye);
  }
  EXPECT_NEAR(advice.heuristic, unseen / all, 0.1);
  EXPECT_GT(unseen / all, 0.3);
  EXPECT_NEAR(advice.angle_deg, std::acos(eye.normalized().dot(advice.eye.normalized())) * 180 / M_PI, 0.01);
  EXPECT_THAT(advice.reason, testing::HasSubstr("not seen"));
}

/// The same images of the same ball; the place of one half is a guess.
TEST(NextView, AnImageOfAGuessIsWorthMore) {
  const Object object = sphere_object();
  Mesh mesh = *object.mesh;
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    mesh.evidence.push_back(vertex.y() > 0 ? ShapeEvidence::kGuessed : ShapeEvidence::kSeen);
  const auto photographed = captures({object.surface, analytic::diffuse(0.2)}, eyes(16, kDistance, -0.98));
  SurfaceLightField known(object.mesh, plain_options()), guessed(std::make_shared<const Mesh>(mesh), plain_options());
  ingest_all(known, photographed);
  ingest_all(guessed, photographed);
  const std::vector<Eigen::Vector3d> places{{0, 0.5, 0}, {0, -0.5, 0}};
  const std::vector<double> before = image_worth(*known.light_field_snapshot(), places),
                            after = image_worth(*guessed.light_field_snapshot(), places);
  EXPECT_GT(after[0], 1.15 * before[0]);
  EXPECT_NEAR(after[1], before[1], 0.02 * before[1]);
  const double share = share_of(*guessed.light_field_snapshot(), {0, 0.5, 0.1}, QualityReason::kShapeGuessed);
  EXPECT_NEAR(share, 0.48, 0.05) << "one half, but for what was seen at grazing angles only";
}

TEST(NextView, SaysWhenAllIsCoveredAndBeforeAnythingIs) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  SurfaceLightField model(object.mesh, plain_options());
  const ViewAdvice first = advise_next_view(*model.light_field_snapshot(), {0.3, 0, 0.4});
  EXPECT_EQ(first.heuristic, 1);
  EXPECT_THAT(first.reason, testing::HasSubstr("not seen"));
  EXPECT_FALSE(first.well_known());
  ingest_all(model, captures(scene, eyes(120, kDistance, -0.3)));
  const ViewAdvice last = advise_next_view(*model.light_field_snapshot(), {0.3, 0, 0.4});
  EXPECT_LT(last.heuristic, 0.35);
  EXPECT_GT(last.heuristic, 0);
  EXPECT_TRUE(last.eye.allFinite());
  EXPECT_TRUE(last.well_known()) << last.worst_psnr_db;
}

TEST(NextView, IsDoneOnlyWhenTheLeastKnownPlaceIsWellKnown) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::diffuse(0.2)};
  std::vector<Eigen::Vector3d> all = eyes(120, kDistance, -0.3), half;
  for (const Eigen::Vector3d& eye : all)
    if (eye.x() > 0.1) half.push_back(eye);
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, half));
  const Eigen::Vector3d eye(0.3, 0, 0.4);
  const ViewAdvice before = advise_next_view(*model.light_field_snapshot(), eye);
  EXPECT_FALSE(before.well_known()) << before.worst_psnr_db;
  EXPECT_LT(before.eye.x(), 0) << "where no image was taken";
  for (const Eigen::Vector3d& other : all)
    if (other.x() <= 0.1) model.ingest(analytic::capture(scene, camera_at(other), analytic::towards_origin(other)));
  const ViewAdvice after = advise_next_view(*model.light_field_snapshot(), eye);
  EXPECT_TRUE(after.well_known()) << after.worst_psnr_db;
  EXPECT_GT(after.worst_psnr_db, before.worst_psnr_db);
}

}  // namespace
}  // namespace sheen
