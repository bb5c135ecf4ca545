// SPDX-License-Identifier: Apache-2.0
// Smooth outlines: truth are areas of polygons clipped to pixels, and many point samples of an analytic sphere.
#include "reconstructor/render/outlines.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/image/color.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/plain_model.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using testing::PlainModel;
using Polygon = std::vector<Eigen::Vector2d>;

constexpr double kStep = 1.0 / 16;  // of alpha

Camera pinhole() {
  return {.width = 161, .height = 121, .fx = 300, .fy = 290, .cx = 75.3, .cy = 62.6};
}
Camera with_lens() {
  Camera camera = pinhole();
  camera.distortion = {-0.25, 0.08, 0.002, -0.001, 0.01};
  return camera;
}

SmoothView smooth(const Mesh& mesh, const Appearance& model, const Camera& camera, const Rigid3& pose) {
  return RayPainter(mesh).paint_smooth(model, Outlines(mesh), camera, pose);
}

/// What of a polygon lies where normal . x <= offset (Sutherland and Hodgman).
Polygon cut(const Polygon& polygon, const Eigen::Vector2d& normal, double offset) {
  Polygon rest;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = normal.dot(a) - offset, db = normal.dot(b) - offset;
    if (da <= 0) rest.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) rest.push_back(a + da / (da - db) * (b - a));
  }
  return rest;
}

double area(const Polygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(sum) / 2;
}

/// Of the square of a pixel.
double covered(const Polygon& polygon, int x, int y) {
  Polygon rest = cut(polygon, {1, 0}, x + 0.5);
  rest = cut(rest, {-1, 0}, -(x - 0.5));
  rest = cut(rest, {0, 1}, y + 0.5);
  return area(cut(rest, {0, -1}, -(y - 0.5)));
}

TEST(Outlines, AlphaIsTheAreaThatAPlateCoversOfAPixel) {
  const Mesh mesh = square_mesh(0.1f, 0, 6);
  const PlainModel model(mesh);
  for (const double turn : {0.0, 0.2, 0.7853981, 1.3}) {
    const Rigid3 pose = look_at({0.13, -0.26, 0.8}, {0.01, 0.02, 0}, {std::sin(turn), std::cos(turn), 0});
    Polygon plate;
    for (const auto& [x, y] : {std::pair{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}})
      plate.push_back(*pinhole().project(pose * Eigen::Vector3d(x, y, 0)));
    const SmoothView view = smooth(mesh, model, pinhole(), pose);
    double sum = 0;
    int partly = 0;
    for (int y = 0; y < view.alpha.height(); ++y)
      for (int x = 0; x < view.alpha.width(); ++x) {
        const double truth = covered(plate, x, y);
        ASSERT_NEAR(view.alpha.at(x, y), truth, 2 * kStep) << x << " " << y;
        sum += view.alpha.at(x, y);
        partly += truth > 0.01 && truth < 0.99;
      }
    EXPECT_GT(partly, 150);
    EXPECT_NEAR(sum, area(plate), 2e-3 * area(plate));
  }
}

TEST(Outlines, AlphaIsThatOfTheAnalyticSphereThroughALens) {
  const Mesh mesh = sphere_mesh(0.1f, 5);
  const PlainModel model(mesh);
  const Camera camera = with_lens();
  const Rigid3 pose = look_at({0.3, 0.25, 0.3}, {0.02, 0, 0.01}, {0, 0, 1}), object_from_camera = pose.inverse();
  const SmoothView view = smooth(mesh, model, camera, pose);
  constexpr int kFine = 12;
  double worst = 0, sum = 0, true_sum = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      int hits = 0;
      for (int i = 0; i < kFine * kFine; ++i) {
        const Eigen::Vector2d place((i % kFine + 0.5) / kFine - 0.5, (i / kFine + 0.5) / kFine - 0.5);
        const Eigen::Vector3d ray = object_from_camera.rotation * *camera.ray(Eigen::Vector2d(x, y) + place);
        hits += analytic::sphere(0.0999)(object_from_camera.translation, ray) < analytic::kMiss;
      }
      const double truth = double(hits) / (kFine * kFine);
      worst = std::max(worst, std::abs(view.alpha.at(x, y) - truth));
      sum += view.alpha.at(x, y);
      true_sum += truth;
    }
  EXPECT_LT(worst, 0.2) << "facets of up to 0.1 mm, which is 0.06 pixels, and what 16 rays can tell";
  EXPECT_NEAR(sum, true_sum, 2e-3 * true_sum);
}

TEST(Outlines, AStrandThinnerThanAPixelIsNotCutIntoDashes) {
  // 0.3 pixels wide: the rays through pixel centres miss most of it.
  Mesh mesh = square_mesh(0.1f, 0, 1);
  for (Eigen::Vector3f& v : mesh.vertices) v.x() *= 0.003f;
  const Rigid3 pose = look_at({0, 0, 0.6}, {0, 0, 0}, {0.1, 1, 0});
  const SmoothView view = smooth(mesh, PlainModel(mesh), pinhole(), pose);
  const double width = 0.0006 / 0.6 * 300 / std::cos(std::atan(0.1));
  int rows = 0, empty_in_the_middle = 0;
  double sum = 0;
  for (int y = 0; y < view.alpha.height(); ++y) {
    double row = 0;
    for (int x = 0; x < view.alpha.width(); ++x) row += view.alpha.at(x, y);
    if (y < 25 || y > 95) continue;
    ++rows;
    sum += row;
    empty_in_the_middle += row == 0;
  }
  EXPECT_EQ(empty_in_the_middle, 0);
  EXPECT_NEAR(sum / rows, width, 0.05 * width);
}

TEST(Outlines, NoRimOverAnyBackground) {
  const Mesh mesh = sphere_mesh(0.1f, 4);
  const Eigen::Vector3f colour(0.25f, 0.6f, 0.1f);
  const SmoothView view =
      smooth(mesh, PlainModel(mesh, colour), with_lens(), look_at({0.4, 0, 0.2}, {0, 0, 0}, {0, 0, 1}));
  const ImageF associated = premultiplied(view);
  const ImageU8 straight = straight_srgb8(view);
  int partly = 0;
  for (int y = 0; y < view.alpha.height(); ++y)
    for (int x = 0; x < view.alpha.width(); ++x) {
      const float alpha = view.alpha.at(x, y);
      ASSERT_EQ(associated.at(x, y, 3), alpha);
      ASSERT_EQ(straight.at(x, y, 3), std::lround(255 * alpha));
      partly += alpha > 0 && alpha < 1;
      for (int c = 0; c < 3; ++c) {
        if (alpha > 0) {
          ASSERT_NEAR(straight.at(x, y, c), 255 * srgb_encode(colour[c]), 0.51) << "the colour as it is";
        }
        for (const float background : {0.0f, colour[c], 1.0f, 20.0f}) {
          const float over = associated.at(x, y, c) + (1 - alpha) * background;
          ASSERT_NEAR(over, alpha * colour[c] + (1 - alpha) * background, 1e-5f * (1 + background));
        }
      }
    }
  EXPECT_GT(partly, 200);
}

TEST(Outlines, WhereOnePartHidesAnotherTheirColoursMixByArea) {
  // A plate before a larger one; each shows its depth. Nothing behind shines through the plate in front.
  const Mesh mesh = joined(square_mesh(0.05f, 0.1f, 3), square_mesh(0.3f, 0, 3));
  PlainModel model(mesh);
  model.shows_place = true;
  const Rigid3 pose = look_at({0, 0, 0.6}, {0, 0, 0}, {0.3, 1, 0});
  Polygon front;
  for (const auto& [x, y] : {std::pair{-0.05, -0.05}, {0.05, -0.05}, {0.05, 0.05}, {-0.05, 0.05}})
    front.push_back(*pinhole().project(pose * Eigen::Vector3d(x, y, 0.1)));
  const SmoothView view = smooth(mesh, model, pinhole(), pose);
  int mixed = 0;
  for (int y = 0; y < view.alpha.height(); ++y)
    for (int x = 0; x < view.alpha.width(); ++x) {
      ASSERT_EQ(view.alpha.at(x, y), 1);
      const double truth = covered(front, x, y);
      ASSERT_NEAR(view.beauty.at(x, y, 2), 0.1 * truth, 0.1 * 2 * kStep);
      mixed += truth > 0.1 && truth < 0.9;
    }
  EXPECT_GT(mixed, 100);
}

TEST(Outlines, AwayFromThemThePictureIsThatOfTheCentres) {
  const Mesh mesh = sphere_mesh(0.1f, 4);
  PlainModel model(mesh);
  model.shows_place = true;
  const Rigid3 pose = look_at({0.4, 0, 0.2}, {0, 0, 0}, {0, 0, 1});
  const SmoothView view = smooth(mesh, model, with_lens(), pose);
  const PaintedView centres = RayPainter(mesh).paint(model, with_lens(), pose);
  const ImageU8 outline = Outlines(mesh).pixels(with_lens(), pose);
  int on = 0;
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x) {
      on += outline.at(x, y) != 0;
      ASSERT_EQ(view.coverage.at(x, y), centres.coverage.at(x, y));
      if (outline.at(x, y)) continue;
      ASSERT_EQ(view.alpha.at(x, y), centres.coverage.at(x, y) > 0 ? 1 : 0);
      for (int c = 0; c < 3; ++c) ASSERT_EQ(view.beauty.at(x, y, c), centres.beauty.at(x, y, c));
    }
  EXPECT_GT(on, 200);
  EXPECT_LT(on, 900) << "a ring one or two pixels wide";
}

TEST(Outlines, PlacesThatNoCameraSeesCostNothingAndMarkNothing) {
  Mesh mesh = square_mesh(1000, 0, 2);
  Camera folded = pinhole();
  folded.distortion = {-2.0, 0, 0, 0, 0};  // turns back at a radius of 0.41
  for (const Camera& camera : {pinhole(), folded})
    for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(999.5, 0, 0.001)}) {
      const ImageU8 marks = Outlines(mesh).pixels(camera, look_at(eye, eye + Eigen::Vector3d(0.1, 0, -1), {0, 1, 0}));
      EXPECT_LT(std::count(marks.data(), marks.data() + marks.size(), 255), marks.size() / 10);
    }
}

}  // namespace
}  // namespace sheen
