// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/ball_lights.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/camera/rigid3.h"
#include "tests/support/expect_error.h"
#include "tests/tracker/lights/chrome_ball_scene.h"

namespace sheen {
namespace {

using Lamps = std::vector<FarLamp>;

struct Errors {
  double worst_deg = 0, rms_deg = 0, rms_uncertainty_deg = 0;
};

class ChromeBall : public ::testing::Test {
 protected:
  BallView view() const {
    return scene_.camera ? BallView(*scene_.camera) : BallView(ImageSize{scene_.width, scene_.height});
  }
  /// One image for each list of lamps.
  BallLights lights(const std::vector<Lamps>& lamps, const std::optional<BallCircle>& about = {}) const {
    return lights_as(view(), lamps, about);
  }
  BallLights lights_as(const BallView& view, const std::vector<Lamps>& lamps,
                       const std::optional<BallCircle>& about = {}) const {
    std::vector<ImageF> images;
    for (const Lamps& lit : lamps) images.push_back(scene_.image(lit, seed_ + static_cast<unsigned>(images.size())));
    return lights_of_ball(
        view, images.size(), [&](std::size_t i) { return images[i]; }, about);
  }
  static Errors errors_of(const BallLights& found, const Lamps& truth) {
    Errors errors;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const auto& [highlight, refusal] = found.images[i];
      if (!highlight) continue;
      const double error = angle_deg(highlight->direction, truth[i].towards);
      errors.worst_deg = std::max(errors.worst_deg, error);
      errors.rms_deg += error * error / static_cast<double>(found.found());
      errors.rms_uncertainty_deg += std::pow(highlight->uncertainty_deg, 2) / static_cast<double>(found.found());
    }
    errors.rms_deg = std::sqrt(errors.rms_deg);
    errors.rms_uncertainty_deg = std::sqrt(errors.rms_uncertainty_deg);
    return errors;
  }
  static std::vector<Lamps> one_by_one(const Lamps& lamps) {
    std::vector<Lamps> each;
    for (const FarLamp& lamp : lamps) each.push_back({lamp});
    return each;
  }

  ChromeBallScene scene_;
  unsigned seed_ = 1;
};

TEST_F(ChromeBall, SaysTheDirectionsOfLightsFromParallelRays) {
  const Lamps lamps = lamps_on_dome(12, 10);
  const BallLights found = lights(one_by_one(lamps));
  EXPECT_EQ(found.found(), lamps.size());
  EXPECT_NEAR(found.outline.circle.centre.x(), scene_.centre.x(), 0.4);
  EXPECT_NEAR(found.outline.circle.centre.y(), scene_.centre.y(), 0.4);
  EXPECT_NEAR(found.outline.circle.radius, scene_.radius, 0.4);
  EXPECT_EQ(found.outline.visible, 1);
  const Errors errors = errors_of(found, lamps);
  EXPECT_LT(errors.worst_deg, 1);
  EXPECT_LT(errors.rms_deg, 2 * errors.rms_uncertainty_deg);
  EXPECT_GT(errors.rms_deg, 0.2 * errors.rms_uncertainty_deg);
}

/// A ball off the axis of a wide lens with distortion: its outline is no circle in the images.
TEST_F(ChromeBall, SaysThemThroughACalibratedLens) {
  scene_.camera = Camera{.width = 480,
                         .height = 360,
                         .fx = 300,
                         .fy = 300,
                         .cx = 236,
                         .cy = 183,
                         .distortion = {-0.25, 0.06, 0.001, -0.0005, 0}};
  scene_.place = {2.6, -1.4, 5.2};
  const Lamps lamps = lamps_on_dome(10, 20);
  const BallLights found = lights(one_by_one(lamps));
  EXPECT_EQ(found.found(), lamps.size());
  EXPECT_LT(errors_of(found, lamps).worst_deg, 1);
  const BallCircle outline = view().in_image(found.outline.circle);
  const BallLights far = lights_as(BallView(ImageSize{scene_.width, scene_.height}), one_by_one(lamps), outline);
  EXPECT_GT(errors_of(far, lamps).worst_deg, 5) << "a camera that is near is not far";
}

TEST_F(ChromeBall, MayBePartlyOutsideTheImage) {
  scene_.centre = {448, 200.5};
  const Lamps lamps = lamps_on_dome(12, 20);
  const BallLights found = lights(one_by_one(lamps));
  EXPECT_NEAR(found.outline.circle.centre.x(), scene_.centre.x(), 0.3);
  EXPECT_NEAR(found.outline.circle.radius, scene_.radius, 0.3);
  EXPECT_LT(found.outline.visible, 0.8);
  EXPECT_GE(found.found(), 6u);
  EXPECT_LT(errors_of(found, lamps).worst_deg, 1);
  for (std::size_t i = 0; i < lamps.size(); ++i) {
    const auto& [highlight, refusal] = found.images[i];
    if (!highlight) EXPECT_THAT(refusal, ::testing::AnyOf("no_highlight", "highlight_cut_off")) << i;
    // Where the mirrored normal lies is known: half way between light and eye.
    const double x = scene_.centre.x() + scene_.radius * (lamps[i].towards + Eigen::Vector3d::UnitZ()).normalized().x();
    if (x > 481) EXPECT_FALSE(highlight) << i;
    if (x < 470) EXPECT_TRUE(highlight) << i;
  }
}

TEST_F(ChromeBall, SmallFaintAndNoisyOnesAreFoundWhereTheyAreSaidToBe) {
  scene_.radius = 14.6;
  scene_.noise = 4;
  Lamps lamps = lamps_on_dome(8, 30);
  for (FarLamp& lamp : lamps) lamp = {lamp.towards, 7, 0.8f};
  const BallLights found = lights(one_by_one(lamps), BallCircle{{252, 172}, 16});
  EXPECT_GE(found.found(), 7u);
  const Errors errors = errors_of(found, lamps);
  EXPECT_LT(errors.worst_deg, 3);
  EXPECT_LT(errors.rms_deg, 2.5 * errors.rms_uncertainty_deg);
}

/// The reported uncertainty is that of the errors.
TEST_F(ChromeBall, ErrsByAsMuchAsItSays) {
  double squares = 0, said = 0;
  for (int run = 0; run < 5; ++run) {
    scene_.centre = {240.1 + 3.37 * run, 160.9 + 2.71 * run};
    scene_.radius = 30 + 9.3 * run;
    scene_.noise = 2;
    seed_ = 100u * static_cast<unsigned>(run);
    const Lamps lamps = lamps_on_dome(6, 20);
    const Errors errors = errors_of(lights(one_by_one(lamps)), lamps);
    squares += errors.rms_deg * errors.rms_deg;
    said += errors.rms_uncertainty_deg * errors.rms_uncertainty_deg;
  }
  EXPECT_LT(squares, 2.25 * said);
  EXPECT_GT(squares, said / 9);
}

TEST_F(ChromeBall, ImagesWithoutOneClearHighlightAreNamed) {
  const Lamps dome = lamps_on_dome(8, 20);
  std::vector<Lamps> lamps = one_by_one(dome);
  const FarLamp behind{.towards = Eigen::Vector3d(0.09, 0.05, -1).normalized()};
  lamps.push_back({});
  lamps.push_back({dome[1], dome[4]});
  lamps.push_back({{.towards = {0, 0.6, 0.8}, .radius_deg = 40}});
  lamps.push_back({behind});
  const BallLights found = lights(lamps);
  EXPECT_EQ(found.found(), 8u);
  EXPECT_EQ(found.images[8].refusal, "no_highlight");
  EXPECT_EQ(found.images[9].refusal, "several_highlights");
  EXPECT_EQ(found.images[10].refusal, "highlight_too_large");
  EXPECT_THAT(found.images[11].refusal, ::testing::AnyOf("highlight_at_rim", "no_highlight"));
  for (const auto& [highlight, refusal] : found.images)
    if (!highlight) EXPECT_FALSE(refusal_text(refusal).empty());
}

/// Something round and glossy may show a highlight now and then: a person must say that it is a ball.
TEST_F(ChromeBall, HighlightsInHalfOfTheImagesAreTooFew) {
  std::vector<Lamps> lamps = one_by_one(lamps_on_dome(4, 20));
  lamps.resize(8);
  expect_error<Error>([&] { lights(lamps); }, {"no ball was found", "4 of 8 images", "--ball"});
  EXPECT_EQ(lights(lamps, BallCircle{{253, 168}, 60}).found(), 4u);
}

TEST_F(ChromeBall, OneImageIsEnough) {
  const Lamps lamps{{.towards = Eigen::Vector3d(-0.3, 0.5, 0.8).normalized()}};
  EXPECT_LT(errors_of(lights({lamps}), lamps).worst_deg, 0.7);
}

TEST_F(ChromeBall, CoinsAreNoBalls) {
  scene_.ball = false;
  const auto lamps = one_by_one(lamps_on_dome(6, 20));
  expect_error<Error>([&] { lights(lamps); }, {"no ball was found", "--ball"});
  expect_error<Error>([&] { lights(lamps, BallCircle{{250, 170}, 60}); }, {"no ball"});
  expect_error<Error>([&] { lights(lamps, BallCircle{{-900, 170}, 60}); }, {"no ball"});
}

/// The outline of a ball is a circle in stereographic projection, and what it mirrors follows from it.
TEST(BallViewTest, StraightensTheOutlineOfABall) {
  const Camera camera{
      .width = 640, .height = 480, .fx = 320, .fy = 322, .cx = 317, .cy = 242, .distortion = {-0.2, 0.05, 0, 0.001, 0}};
  const BallView view(camera);
  const Eigen::Vector3d centre(-2.1, 1.2, 4);
  std::vector<Eigen::Vector2d> outline;
  const Eigen::Vector3d axis = centre.normalized(), across = axis.unitOrthogonal(), other = axis.cross(across);
  const double sine = 1 / centre.norm(), cosine = std::sqrt(1 - sine * sine);
  BallCircle circle;
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (int i = 0; i < 3600; ++i) {
    const double angle = M_PI * i / 1800;
    const Eigen::Vector3d ray = cosine * axis + sine * (std::cos(angle) * across + std::sin(angle) * other);
    const auto pixel = camera.project(ray);
    ASSERT_TRUE(pixel);
    const Eigen::Vector2d place = view.straightened({*pixel, 1e-3}).centre;
    EXPECT_LT((*view.ray(place) - ray).norm(), 1e-6);
    outline.push_back(place);
    low = low.min(place.array());
    high = high.max(place.array());
  }
  circle = {(low + high) / 2, (high - low).mean() / 2};
  for (const Eigen::Vector2d& place : outline) EXPECT_NEAR((place - circle.centre).norm(), circle.radius, 2e-3);
  // The middle of the ball mirrors the camera.
  const MirrorBall ball(view, circle);
  const Eigen::Vector2d middle = view.straightened({*camera.project(centre), 1e-3}).centre;
  EXPECT_LT(angle_deg(*ball.light_at(middle), Eigen::Vector3d(-centre.x(), centre.y(), centre.z())), 0.05);
  EXPECT_FALSE(ball.light_at(circle.centre + Eigen::Vector2d(1.01 * circle.radius, 0)));
}

}  // namespace
}  // namespace sheen
