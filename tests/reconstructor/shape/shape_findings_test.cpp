// SPDX-License-Identifier: Apache-2.0
//
// What keeps a shape from being better is named; of a good capture nothing is.
#include "reconstructor/shape/shape_findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "reconstructor/shape/shape.h"
#include "tests/support/analytic_scene.h"

namespace sheen {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kRadius = 0.1, kDistance = 0.5;
const Camera kCamera{.width = 66, .height = 55, .fx = 115, .fy = 115, .cx = 32.5, .cy = 27};
constexpr double kPixel = kDistance / 115;
constexpr int kImages = 44;
using Captures = std::vector<Capture>;

analytic::Scene ball(const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  return {.surface = [centre, sphere = analytic::sphere(kRadius)](
                         const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) { return sphere(eye - centre, ray); },
          .radiance = [centre, of = analytic::diffuse(0.03)](const Eigen::Vector3d& p,
                                                             const Eigen::Vector3d& d) { return of(p - centre, d); },
          .background = {0.001, 0.001, 0.001}};
}

void add_mask(const analytic::Scene& scene, Capture& capture) {
  const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
  capture.mask = ImageU8(capture.camera.width, capture.camera.height, 1);
  for (int y = 0; y < capture.mask.height(); ++y)
    for (int x = 0; x < capture.mask.width(); ++x) {
      const Eigen::Vector3d ray = object_from_camera.rotation * *capture.camera.ray({double(x), double(y)});
      capture.mask.at(x, y) = scene.surface(object_from_camera.translation, ray) < analytic::kMiss ? 255 : 0;
    }
}

Captures captures_of(const analytic::Scene& scene, const std::vector<Eigen::Vector3d>& eyes, bool masks = true,
                     const Camera& camera = kCamera) {
  Captures captures;
  for (const Eigen::Vector3d& eye : eyes) {
    captures.push_back(analytic::capture(scene, camera, analytic::towards_origin(eye)));
    captures.back().name = std::to_string(captures.size()) + ".png";
    if (masks) add_mask(scene, captures.back());
  }
  return captures;
}

std::vector<Eigen::Vector3d> all_round(int count = kImages) {
  return analytic::eyes(count, kDistance, -0.98);
}

std::vector<ShapeFinding> found_in(const Captures& captures) {
  RefinementImages images;
  for (const Capture& capture : captures) images.cameras.push_back({capture.camera, capture.pose.camera_from_object});
  images.read = [&](std::size_t i) { return captures[i]; };
  return findings_of(find_shape(images, {}).measures);
}

auto kind(const std::string& name) {
  return Field("kind", &ShapeFinding::kind, name);
}
auto about(const std::vector<std::string>& images) {
  return Field("images", &ShapeFinding::images, images);
}
auto says(const std::string& part) {
  return Field("sentence", &ShapeFinding::sentence, HasSubstr(part));
}

}  // namespace

void PrintTo(const ShapeFinding& finding, std::ostream* out) {
  *out << finding.kind << ": " << finding.sentence;
}

namespace {

TEST(ShapeFindings, OfAGoodCaptureThereAreNone) {
  EXPECT_THAT(found_in(captures_of(ball(), all_round())), IsEmpty());
}

TEST(ShapeFindings, OfOneBeforeADarkBackgroundThereAreNone) {
  EXPECT_THAT(found_in(captures_of(ball(), all_round(), false)), IsEmpty());
}

/// By more than the half of itself, and by four pixels: named to an image, for one may show little of it.
TEST(ShapeFindings, AnObjectThatMoved) {
  for (const double by : {0.06, 4 * kPixel}) {
    Captures captures = captures_of(ball(), all_round());
    const Captures later = captures_of(ball({by, 0.3 * by, 0}), all_round());
    for (std::size_t i = 23; i < captures.size(); ++i) captures[i] = later[i];
    EXPECT_THAT(found_in(captures), ElementsAre(AllOf(kind("moved"), AnyOf(about({"22.png"}), about({"23.png"})))))
        << by;
  }
}

TEST(ShapeFindings, PosesThatAreOff) {
  std::mt19937 chance(4);
  std::normal_distribution<double> off(0, 1.2 * kPixel);
  Captures captures = captures_of(ball(), all_round());
  for (Capture& capture : captures)
    capture.pose.camera_from_object.translation += Eigen::Vector3d(off(chance), off(chance), 0);
  EXPECT_THAT(found_in(captures), ElementsAre(AllOf(kind("poses"), says("refine --poses"))));
}

TEST(ShapeFindings, AnImageThatShowsSomethingElse) {
  Captures captures = captures_of(ball(), all_round());
  analytic::Scene other = ball();
  other.radiance = analytic::diffuse(0.017);
  captures[8].image = captures_of(other, analytic::eyes(7, kDistance, -0.9))[3].image;
  EXPECT_THAT(found_in(captures), ElementsAre(AllOf(kind("images"), about({"9.png"}))));
}

TEST(ShapeFindings, MasksThatDisagree) {
  Captures captures = captures_of(ball(), all_round());
  for (const std::size_t i : {4u, 20u})
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width / 2; ++x) captures[i].mask.at(x, y) = 0;
  EXPECT_THAT(found_in(captures), ElementsAre(AllOf(kind("outlines"), about({"5.png", "21.png"}))));
}

TEST(ShapeFindings, ABackgroundThatCannotBeTold) {
  analytic::Scene scene = ball();
  scene.surface = analytic::nearest_of(analytic::sphere(0.05), analytic::square(0.6, -0.05));
  EXPECT_THAT(found_in(captures_of(scene, analytic::eyes(20, kDistance, 0.4), false)), Contains(kind("background")));
}

TEST(ShapeFindings, AnObjectThatReachesOutOfThePictures) {
  Camera near = kCamera;
  near.fx = near.fy = 145;
  near.cx += 12;
  EXPECT_THAT(found_in(captures_of(ball(), all_round(20), true, near)),
              Contains(AllOf(kind("cut off"), says("step back"))));
}

TEST(ShapeFindings, AnObjectThatReachesBeyondTheStage) {
  const analytic::Scene scene = ball({0.04, 0, 1.2 * kRadius});
  Captures captures = captures_of(scene, analytic::eyes(20, kDistance, 0.1));
  for (Capture& capture : captures) {
    TagObservation tag{.id = 0, .used = true};
    const Eigen::Vector3d corners[] = {{-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {-0.1, 0.1, 0}};
    for (std::size_t i = 0; i < 4; ++i)
      tag.corners[i] = *capture.camera.project(capture.pose.camera_from_object * corners[i]);
    capture.tags.push_back(tag);
  }
  EXPECT_THAT(found_in(captures), Contains(AllOf(kind("cut off"), says("between the stage's tags"))));
}

/// From above alone, and from one side alone.
TEST(ShapeFindings, WhatNoImageShows) {
  EXPECT_THAT(found_in(captures_of(ball(), analytic::eyes(kImages, kDistance, 0.05))), ElementsAre(kind("underside")));
  std::vector<Eigen::Vector3d> aside;
  for (const Eigen::Vector3d& eye : analytic::eyes(2 * kImages, kDistance, -0.98))
    if (eye.x() > -0.1 * kDistance) aside.push_back(eye);
  EXPECT_THAT(found_in(captures_of(ball(), aside)), Contains(AllOf(kind("directions"), says("10 to 15 degrees"))));
}

TEST(ShapeFindings, APartWithoutTexture) {
  analytic::Scene scene = ball();
  scene.radiance = [textured = scene.radiance](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
    return p.x() > 0.2 * kRadius ? Eigen::Vector3d(0.4, 0.4, 0.4) : textured(p, d);
  };
  EXPECT_THAT(found_in(captures_of(scene, all_round())), ElementsAre(kind("smooth")));
}

/// A rod that is a pixel wide stands off the ball.
TEST(ShapeFindings, PartsThinnerThanTheCells) {
  analytic::Scene scene = ball();
  const analytic::Surface rod = [](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    constexpr double kThick = 0.5 * kPixel, kEnd = 1.8 * kRadius;  // round the axis x = y
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 1, 0).normalized();
    const Eigen::Vector3d o = eye - axis.dot(eye) * axis, d = ray - axis.dot(ray) * axis;
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - kThick * kThick, rest = b * b - a * c;
    if (!(rest >= 0) || a == 0) return analytic::kMiss;
    const double t = (-b - std::sqrt(rest)) / a, along = axis.dot(eye + t * ray);
    return t > 0 && along > 0 && along < kEnd ? t : analytic::kMiss;
  };
  scene.surface = analytic::nearest_of(scene.surface, rod);
  EXPECT_THAT(found_in(captures_of(scene, all_round())), Contains(kind("thin")));
}

}  // namespace
}  // namespace sheen
