// SPDX-License-Identifier: Apache-2.0
//
// Images that no shape should be expected of. What is found is a sound mesh, or an error says what to do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "reconstructor/shape/shape.h"
#include "tests/reconstructor/shape/closed_mesh.h"
#include "tests/support/analytic_scene.h"

namespace sheen {
namespace {

constexpr double kRadius = 0.1, kDistance = 0.5;
const Camera kSmall{.width = 84, .height = 70, .fx = 147, .fy = 147, .cx = 41.5, .cy = 34.5};
using Captures = std::vector<Capture>;

/// A textured ball before a dark background.
analytic::Scene dark_ball() {
  return {analytic::sphere(kRadius), analytic::diffuse(0.03), {0.001, 0.001, 0.001}};
}

analytic::Surface sphere_at(const Eigen::Vector3d& centre, double radius) {
  return [centre, sphere = analytic::sphere(radius)](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    return sphere(eye - centre, ray);
  };
}

ImageU8 mask_of(const analytic::Scene& scene, const Capture& capture) {
  const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
  ImageU8 mask(capture.camera.width, capture.camera.height, 1);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      const Eigen::Vector3d ray = object_from_camera.rotation * *capture.camera.ray({double(x), double(y)});
      mask.at(x, y) = scene.surface(object_from_camera.translation, ray) < analytic::kMiss ? 255 : 0;
    }
  return mask;
}

Capture seen_from(const Eigen::Vector3d& eye, const Camera& camera = kSmall,
                  const analytic::Scene& scene = dark_ball()) {
  return analytic::capture(scene, camera, analytic::towards_origin(eye));
}

Captures all_round(int count, const Camera& camera = kSmall) {
  Captures captures;
  for (const Eigen::Vector3d& eye : analytic::eyes(count, kDistance, -0.98)) captures.push_back(seen_from(eye, camera));
  return captures;
}

Captures masked(Captures captures) {
  for (Capture& capture : captures) capture.mask = mask_of(dark_ball(), capture);
  return captures;
}

/// Every `step`th capture, changed.
template <typename Change>
Captures some_changed(Captures captures, std::size_t step, const Change& change) {
  for (std::size_t i = 0; i < captures.size(); i += step) change(captures[i], i);
  return captures;
}

template <typename Value>
void set_pixels(Capture& capture, const Value& value) {
  ImageF picture(capture.camera.width, capture.camera.height, 3);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) Eigen::Map<Eigen::Vector3f>(picture.pixel(x, y)).setConstant(value(x, y));
  capture.image = analytic::float_image(picture);
}

Captures filled_with(float value) {
  return some_changed(all_round(12), 1,
                      [&](Capture& capture, std::size_t) { set_pixels(capture, [&](int, int) { return value; }); });
}

Captures of_noise() {
  std::mt19937 chance(3);
  return some_changed(all_round(12), 1, [&](Capture& capture, std::size_t) {
    set_pixels(capture, [&](int, int) { return std::uniform_real_distribution<float>(0, 1)(chance); });
  });
}

/// Some pixels are no numbers, or none that light has.
Captures with_broken_pixels(std::size_t step) {
  return some_changed(masked(all_round(18)), step, [](Capture& capture, std::size_t i) {
    ImageF picture = analytic::picture(dark_ball(), capture.camera, capture.pose.camera_from_object);
    const float broken[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30f};
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x)
        if ((x * 7 + y * 3 + static_cast<int>(i)) % 11 == 0)
          Eigen::Map<Eigen::Vector3f>(picture.pixel(x, y)).setConstant(broken[(x + y) % 3]);
    capture.image = analytic::float_image(picture);
  });
}

/// As if each had been taken from elsewhere.
Captures with_wrong_poses(Captures captures, std::size_t step) {
  const auto elsewhere = analytic::eyes(37, kDistance, -0.9);
  return some_changed(std::move(captures), step, [&](Capture& capture, std::size_t i) {
    capture.pose.camera_from_object = analytic::towards_origin(elsewhere[(i * 11 + 5) % elsewhere.size()]);
  });
}

Captures looking_anywhere() {
  std::mt19937 chance(5);
  const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(chance); };
  return some_changed(all_round(12), 1, [&](Capture& capture, std::size_t) {
    const double w = number(), x = number(), y = number(), z = number();
    capture.pose.camera_from_object.rotation = Eigen::Quaterniond(w, x, y, z).normalized();
  });
}

Captures from_one_side() {
  Captures captures;
  for (const Eigen::Vector3d& eye : analytic::eyes(10, kDistance, 0.9)) captures.push_back(seen_from(eye));
  return captures;
}

/// From where one camera stood, or a few.
Captures from_places(int places, int times) {
  Captures captures;
  for (const Capture& capture : masked(all_round(places)))
    for (int i = 0; i < times; ++i) captures.push_back(capture);
  return captures;
}

Captures from_inside(Captures captures, std::size_t step) {
  return some_changed(std::move(captures), step, [](Capture& capture, std::size_t i) {
    const Eigen::Vector3d eye = 0.3 * kRadius * Eigen::Vector3d(std::sin(double(i)), std::cos(double(i)), 0.4);
    capture = seen_from(eye);
    capture.mask = ImageU8(capture.camera.width, capture.camera.height, 1, 255);
  });
}

Captures with_focal_lengths_apart() {
  Captures captures;
  const auto eyes = analytic::eyes(18, kDistance, -0.98);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const double factor = i % 3 == 0 ? 20 : i % 3 == 1 ? 0.1 : 1;
    Camera camera = kSmall;
    camera.fx *= factor;
    camera.fy *= factor;
    captures.push_back(seen_from(eyes[i], camera));
  }
  return masked(captures);
}

Captures of_sizes_apart() {
  Captures captures;
  const auto eyes = analytic::eyes(18, kDistance, -0.98);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const Camera camera = i % 3 == 0 ? kSmall.scaled(31, 47) : i % 3 == 1 ? kSmall.scaled(400, 90) : kSmall;
    captures.push_back(seen_from(eyes[i], camera));
  }
  return captures;
}

Captures of_one_pixel(std::size_t step) {
  return some_changed(masked(all_round(18)), step, [](Capture& capture, std::size_t) {
    const Rigid3 pose = capture.pose.camera_from_object;
    capture = analytic::capture(dark_ball(), kSmall.scaled(1, 1), pose);
  });
}

Captures with_masks_of(std::uint8_t value, std::size_t step) {
  return some_changed(masked(all_round(18)), step, [&](Capture& capture, std::size_t) {
    capture.mask = ImageU8(capture.camera.width, capture.camera.height, 1, value);
  });
}

/// The ball is half out of each picture, at one side or another.
Captures out_of_the_frame() {
  Captures captures;
  const auto eyes = analytic::eyes(18, kDistance, -0.98);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    Camera camera = kSmall;
    camera.cx += (i % 2 == 0 ? 1 : -1) * 0.45 * camera.width;
    captures.push_back(seen_from(eyes[i], camera));
  }
  return masked(captures);
}

/// Something else is before the ball in every third picture, each time elsewhere.
Captures with_a_hand(bool masks) {
  Captures captures = some_changed(all_round(18), 3, [](Capture& capture, std::size_t i) {
    const Eigen::Vector3d eye = camera_centre(capture.pose.camera_from_object);
    const Eigen::Vector3d side = eye.cross(Eigen::Vector3d(0.3, 0.5, double(i % 5) - 2)).normalized();
    analytic::Scene scene = dark_ball();
    scene.surface = analytic::nearest_of(scene.surface, sphere_at(0.5 * eye + 0.06 * side, 0.04));
    capture = analytic::capture(scene, kSmall, capture.pose.camera_from_object);
    capture.mask = mask_of(scene, capture);
  });
  if (!masks) return some_changed(captures, 1, [](Capture& capture, std::size_t) { capture.mask = {}; });
  for (Capture& capture : captures)
    if (capture.mask.empty()) capture.mask = mask_of(dark_ball(), capture);
  return captures;
}

/// The ball was pushed aside after half of the pictures.
Captures of_what_moved() {
  analytic::Scene moved = dark_ball();
  const Eigen::Vector3d by(0.08, 0.02, 0);
  moved.surface = sphere_at(by, kRadius);
  moved.radiance = [by, still = dark_ball().radiance](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
    return still(p - by, d);
  };
  return some_changed(all_round(18), 2, [&](Capture& capture, std::size_t) {
    capture = analytic::capture(moved, kSmall, capture.pose.camera_from_object);
  });
}

Captures far_and_tiny() {
  Captures captures;
  for (const Eigen::Vector3d& eye : analytic::eyes(12, 40 * kDistance, -0.98)) captures.push_back(seen_from(eye));
  return captures;
}

struct Hostile {
  std::string name;
  Captures (*captures)();
  bool mesh = false;  ///< one must be found
};

/// What printing a failed test's name needs.
void PrintTo(const Hostile& hostile, std::ostream* out) {
  *out << hostile.name;
}

class HostileImages : public ::testing::TestWithParam<Hostile> {};

TEST_P(HostileImages, AreToldOrGiveASoundMesh) {
  const Captures captures = GetParam().captures();
  RefinementImages images;
  for (const Capture& capture : captures) images.cameras.push_back({capture.camera, capture.pose.camera_from_object});
  images.read = [&](std::size_t i) { return captures[i]; };
  try {
    const FoundShape found = find_shape(images, {});
    expect_closed(found.mesh);
    EXPECT_EQ(found.mesh.evidence.size(), found.mesh.vertices.size());
    for (const Eigen::Vector3f& vertex : found.mesh.vertices) ASSERT_TRUE(vertex.allFinite());
  } catch (const Error& error) {
    EXPECT_FALSE(GetParam().mesh) << error.what();
    EXPECT_THAT(
        std::string(error.what()),
        ::testing::AnyOf(::testing::HasSubstr("check"), ::testing::HasSubstr("needs"), ::testing::HasSubstr("take")));
    RecordProperty("said", error.what());
  }
}

INSTANTIATE_TEST_SUITE_P(
    FindShape, HostileImages,
    ::testing::Values(
        Hostile{"FromOneSide", from_one_side}, Hostile{"FromOneSideMasked", [] { return masked(from_one_side()); }},
        Hostile{"OneWrongPoseInTen", [] { return with_wrong_poses(masked(all_round(20)), 10); }, true},
        Hostile{"OneWrongPoseInTenUnmasked", [] { return with_wrong_poses(all_round(20), 10); }, true},
        Hostile{"AllPosesWrong", [] { return with_wrong_poses(all_round(18), 1); }},
        Hostile{"LookingAnywhere", looking_anywhere}, Hostile{"Black", [] { return filled_with(0); }},
        Hostile{"White", [] { return filled_with(1); }}, Hostile{"Noise", of_noise},
        Hostile{"AllNaN", [] { return filled_with(std::numeric_limits<float>::quiet_NaN()); }},
        Hostile{"NaNInSome", [] { return with_broken_pixels(3); }, true},
        Hostile{"NaNInAll", [] { return with_broken_pixels(1); }},
        Hostile{"OnePixelInSome", [] { return of_one_pixel(4); }, true},
        Hostile{"OnePixelInAll", [] { return of_one_pixel(1); }}, Hostile{"SizesApart", of_sizes_apart, true},
        Hostile{"SomeMasksEmpty", [] { return with_masks_of(0, 6); }, true},
        Hostile{"AllMasksEmpty", [] { return with_masks_of(0, 1); }},
        Hostile{"SomeMasksFull", [] { return with_masks_of(255, 3); }, true},
        Hostile{"AllMasksFull", [] { return with_masks_of(255, 1); }},
        Hostile{"OneCameraInside", [] { return from_inside(masked(all_round(18)), 18); }, true},
        Hostile{"AllCamerasInside", [] { return from_inside(all_round(12), 1); }},
        Hostile{"CopiesOfOneView", [] { return from_places(1, 10); }},
        Hostile{"CopiesOfThreeViews", [] { return from_places(3, 6); }},
        Hostile{"CopiesOfManyViews", [] { return from_places(18, 2); }, true},
        Hostile{"FocalLengthsApart", with_focal_lengths_apart}, Hostile{"OutOfTheFrame", out_of_the_frame},
        Hostile{"AHand", [] { return with_a_hand(false); }, true},
        Hostile{"AHandInTheMasks", [] { return with_a_hand(true); }, true}, Hostile{"Moved", of_what_moved},
        Hostile{"FarAndTiny", far_and_tiny}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace sheen
