// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/ray_painter.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/image/color.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/plain_model.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using testing::PlainModel;

Camera pinhole() {
  return {.width = 201, .height = 151, .fx = 300, .fy = 290, .cx = 95.3, .cy = 78.6};
}
Camera with_lens() {
  Camera camera = pinhole();
  camera.distortion = {-0.25, 0.08, 0.002, -0.001, 0.01};
  return camera;
}
Camera fisheye() {
  Camera camera = pinhole();
  camera.fx = camera.fy = 120;
  camera.lens = LensModel::kFisheye;
  camera.distortion = {0.05, -0.01, 0.002, 0, 0};
  return camera;
}

/// Largest sphere round the origin that fits inside the facets.
double inner_radius(const Mesh& mesh) {
  double radius = analytic::kMiss;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    radius = std::min(radius, double(mesh.area_normal(t).normalized().dot(mesh.corner(t, 0))));
  return radius;
}

TEST(RayPainter, TheSilhouetteIsThatOfTheAnalyticSphereThroughEveryLens) {
  const Mesh mesh = sphere_mesh(0.1f, 5);
  const double inner = inner_radius(mesh);
  ASSERT_GT(inner, 0.0999);
  const PlainModel model(mesh);
  const RayPainter painter(mesh);
  for (const Camera& camera : {pinhole(), with_lens(), fisheye()})
    for (const Eigen::Vector3d& target : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.12, -0.05, 0.03)}) {
      const Rigid3 pose = look_at({0.3, 0.25, 0.3}, target, {0, 0, 1});
      const Rigid3 object_from_camera = pose.inverse();
      const PaintedView view = painter.paint(model, camera, pose);
      int inside = 0, outside = 0, undecided = 0;
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
          const Eigen::Vector3d ray = object_from_camera.rotation * *camera.ray({double(x), double(y)});
          const bool hits = analytic::sphere(inner)(object_from_camera.translation, ray) < analytic::kMiss;
          const bool misses = analytic::sphere(0.1)(object_from_camera.translation, ray) == analytic::kMiss;
          if (hits)
            ASSERT_EQ(view.coverage.at(x, y), 255) << x << " " << y;
          else if (misses)
            ASSERT_EQ(view.coverage.at(x, y), 0) << x << " " << y;
          inside += hits;
          outside += misses;
          undecided += !hits && !misses;
        }
      EXPECT_GT(inside, 800);
      EXPECT_GT(outside, 1000);
      EXPECT_LE(undecided, inside / 100) << "pixels whose ray passes between the facets and the sphere";
    }
}

TEST(RayPainter, AConstantModelGivesAConstantPictureAndZeroOutside) {
  const Mesh mesh = sphere_mesh(0.1f, 3);
  const PlainModel model(mesh, {0.25f, 1.5f, 7});
  const PaintedView view = RayPainter(mesh).paint(model, with_lens(), look_at({0.4, 0, 0.2}, {0, 0, 0}, {0, 0, 1}));
  for (int y = 0; y < view.beauty.height(); ++y)
    for (int x = 0; x < view.beauty.width(); ++x) {
      const Eigen::Vector3f rgb = Eigen::Map<const Eigen::Vector3f>(view.beauty.pixel(x, y));
      const bool surface = view.coverage.at(x, y) == 255;
      EXPECT_EQ(rgb, surface ? Eigen::Vector3f(0.25f, 1.5f, 7) : Eigen::Vector3f(0, 0, 0));
      EXPECT_EQ(view.heuristic.at(x, y), surface ? 0.5f : 0);
      EXPECT_EQ(view.reason.at(x, y), surface ? 1 + static_cast<int>(QualityReason::kOblique) : 0);
    }
}

TEST(RayPainter, CoverageTellsImputedFromBoth) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  PlainModel model(mesh);
  const auto middle = [&] {
    const PaintedView view =
        RayPainter(mesh).paint(model, pinhole(), look_at({0.01, -0.01, 0.4}, {0.01, -0.01, 0}, {0, 1, 0}));
    return view.coverage.at(view.coverage.width() / 2, view.coverage.height() / 2);
  };
  EXPECT_EQ(middle(), kCoverageMeasured);
  model.imputed = {0};
  EXPECT_EQ(middle(), kCoverageImputed);
  model.unseen = {0};
  EXPECT_EQ(middle(), kCoverageUnseen);
}

TEST(RayPainter, CoverageTellsMeasuredFromUnseen) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);  // triangle 0 lies below the diagonal x = y, triangle 1 above it
  PlainModel model(mesh);
  model.unseen = {1};
  const Rigid3 pose = look_at({0, 0, 0.4}, {0, 0, 0}, {0, 1, 0});
  const PaintedView view = RayPainter(mesh).paint(model, pinhole(), pose);
  const Rigid3 object_from_camera = pose.inverse();
  int measured = 0, unseen = 0;
  for (int y = 0; y < view.coverage.height(); ++y)
    for (int x = 0; x < view.coverage.width(); ++x) {
      const Eigen::Vector3d ray = object_from_camera.rotation * *pinhole().ray({double(x), double(y)});
      const Eigen::Vector3d p = object_from_camera.translation - object_from_camera.translation.z() / ray.z() * ray;
      if (std::abs(p.x() - p.y()) < 1e-6 || std::abs(std::abs(p.x()) - 0.1) < 1e-6) continue;
      const bool on = std::abs(p.x()) < 0.1 && std::abs(p.y()) < 0.1;
      ASSERT_EQ(view.coverage.at(x, y), !on ? 0 : p.x() > p.y() ? 255 : 128) << p.transpose();
      measured += view.coverage.at(x, y) == 255;
      unseen += view.coverage.at(x, y) == 128;
    }
  EXPECT_GT(measured, 5000);
  EXPECT_GT(unseen, 5000);
}

TEST(RayPainter, TheInsideOfAnOpenObjectIsPlainGreyAndUnseen) {
  // A cup without a lid, seen from above and from within: its inside does not wear the pattern of its outside.
  Mesh cup = sphere_mesh(0.1f, 3);
  std::erase_if(cup.triangles, [&](const Triangle& t) {
    return std::max({cup.vertices[t[0]].z(), cup.vertices[t[1]].z(), cup.vertices[t[2]].z()}) > 0.05f;
  });
  const Eigen::Vector3f colour(0.25f, 1.5f, 7), grey = Eigen::Vector3f::Constant(srgb_decode(0.35f));
  const PlainModel model(cup, colour);
  const RayPainter painter(cup);
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0.15, 0, 0.4), Eigen::Vector3d(0, 0, -0.02)}) {
    const Rigid3 pose = look_at(eye, {0, 0, -0.1}, {0, 1, 0});
    const PaintedView view = painter.paint(model, pinhole(), pose);
    const std::vector<Hit> hits = painter.cast(pinhole(), pose);
    int backs = 0;
    for (int y = 0; y < view.beauty.height(); ++y)
      for (int x = 0; x < view.beauty.width(); ++x) {
        const Hit& hit = hits[std::size_t(y) * view.beauty.width() + x];
        const Eigen::Vector3f rgb = Eigen::Map<const Eigen::Vector3f>(view.beauty.pixel(x, y));
        if (!hit || hit.front)
          EXPECT_EQ(rgb, hit ? colour : Eigen::Vector3f(0, 0, 0));
        else
          EXPECT_TRUE(rgb.isApprox(grey)) << rgb.transpose();
        EXPECT_EQ(view.coverage.at(x, y), !hit ? 0 : hit.front ? kCoverageMeasured : kCoverageUnseen);
        if (!hit || hit.front) continue;
        EXPECT_EQ(view.heuristic.at(x, y), 1);
        EXPECT_EQ(view.reason.at(x, y), 1 + static_cast<int>(QualityReason::kUnseen));
        ++backs;
      }
    EXPECT_GT(backs, 1000);
  }
}

TEST(RayPainter, PlacesOnTheSurfaceAreHandedToTheModelExactly) {
  const Mesh mesh = square_mesh(0.1f, 0.02f, 5);
  PlainModel model(mesh);
  model.shows_place = true;
  const Rigid3 pose = look_at({0.1, -0.15, 0.4}, {0.02, 0, 0}, {0, 0, 1});
  const PaintedView view = RayPainter(mesh).paint(model, with_lens(), pose);
  const Rigid3 object_from_camera = pose.inverse();
  int compared = 0;
  for (int y = 0; y < view.coverage.height(); ++y)
    for (int x = 0; x < view.coverage.width(); ++x) {
      if (view.coverage.at(x, y) == 0) continue;
      const Eigen::Vector3d eye = object_from_camera.translation;
      const Eigen::Vector3d ray = object_from_camera.rotation * *with_lens().ray({double(x), double(y)});
      const Eigen::Vector3f truth = (eye + (0.02 - eye.z()) / ray.z() * ray).cast<float>();
      EXPECT_LT((Eigen::Map<const Eigen::Vector3f>(view.beauty.pixel(x, y)) - truth).norm(), 1e-6f);
      ++compared;
    }
  EXPECT_GT(compared, 5000);
  EXPECT_LT((model.eye - Eigen::Vector3d(0.1, -0.15, 0.4)).norm(), 1e-12);
}

TEST(RayPainter, PixelsThatTheLensCannotReachStayEmpty) {
  const Mesh mesh = square_mesh(10, 0, 1);
  Camera folded = pinhole();
  folded.distortion = {-2.0, 0, 0, 0, 0};  // turns back at a radius of 0.41, which is 0.27 in the picture
  const PaintedView view = RayPainter(mesh).paint(PlainModel(mesh), folded, look_at({0, 0, 1}, {0, 0, 0}, {0, 1, 0}));
  const double reach = std::sqrt(1 / 6.0) * (1 - 2 / 6.0);
  for (int y = 0; y < view.coverage.height(); ++y)
    for (int x = 0; x < view.coverage.width(); ++x) {
      const double r = std::hypot((x - folded.cx) / folded.fx, (y - folded.cy) / folded.fy);
      if (r < reach - 1e-3) EXPECT_EQ(view.coverage.at(x, y), 255);
      if (r > reach + 1e-3) EXPECT_EQ(view.coverage.at(x, y), 0);
    }
}

}  // namespace
}  // namespace sheen
