// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "reconstructor/models/surface_light_field/gl/range_allocator.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/orbit_camera.h"
#include "reconstructor/render/gl/view_action.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/gl/viewer_feed.h"
#include "reconstructor/render/guidance.h"
#include "reconstructor/surface/opening_view.h"

namespace sheen {
namespace {

TEST(RangeAllocator, NeverOverlapsAndLosesNothing) {
  RangeAllocator ranges;
  std::mt19937 random(7);
  std::map<std::size_t, std::size_t> held;
  std::size_t sum = 0;
  ranges.extend(500);
  for (int step = 0; step < 5000; ++step) {
    if (step % 1000 == 999) ranges.extend(100);
    if (held.empty() || random() % 2) {
      const std::size_t size = 1 + random() % 40;
      const auto first = ranges.allocate(size);
      if (!first) continue;
      ASSERT_LE(*first + size, ranges.capacity());
      const auto next = held.lower_bound(*first);
      if (next != held.end()) {
        ASSERT_LE(*first + size, next->first);
      }
      if (next != held.begin()) {
        ASSERT_LE(std::prev(next)->first + std::prev(next)->second, *first);
      }
      held.emplace(*first, size);
      sum += size;
    } else {
      auto victim = held.begin();
      std::advance(victim, random() % held.size());
      ranges.release(victim->first, victim->second);
      sum -= victim->second;
      held.erase(victim);
    }
    ASSERT_EQ(ranges.used(), sum);
  }
  for (const auto& [first, size] : held) ranges.release(first, size);
  EXPECT_EQ(ranges.allocate(ranges.capacity()), 0u) << "all gaps have melted into one";
}

TEST(OrbitCamera, KeepsTheObjectInTheMiddleAndInThePicture) {
  OrbitCamera orbit;
  const BoundingSphere object{{1, 2, 3}, 0.5};
  orbit.frame(object);
  for (const auto& [width, height] : {std::pair{800, 600}, {400, 900}}) {
    for (int i = 0; i < 20; ++i) {
      orbit.orbit(0.7, 0.3 * (i % 5 - 2));
      const Viewpoint view = orbit.viewpoint(width, height);
      const auto middle = view.camera.project(view.camera_from_object * object.centre);
      ASSERT_TRUE(middle);
      EXPECT_NEAR(middle->x(), (width - 1) / 2.0, 1e-6);
      EXPECT_NEAR(middle->y(), (height - 1) / 2.0, 1e-6);
      // The sphere's outline, seen from distance d, has a half angle of asin(r / d).
      const double d = (view.eye() - object.centre).norm();
      const double outline = view.camera.fx * std::tan(std::asin(object.radius / d));
      EXPECT_LT(outline, 0.5 * std::min(width, height));
      EXPECT_GT(outline, 0.4 * std::min(width, height));
    }
  }
}

TEST(OrbitCamera, DraggingMovesWhatIsSeenWithTheMouse) {
  OrbitCamera orbit;
  orbit.frame({{0, 0, 0}, 1});
  const auto where = [&](const Eigen::Vector3d& p) {
    const Viewpoint view = orbit.viewpoint(1000, 1000);
    return *view.camera.project(view.camera_from_object * p);
  };
  const Eigen::Vector2d before = where({0, 0, 0});
  orbit.pan(-0.1, 0);  // the mouse went right by a tenth of the height
  EXPECT_NEAR(where({0, 0, 0}).x() - before.x(), 100, 1e-6);
  orbit.pan(0, 0.1);  // and down
  EXPECT_NEAR(where({0, 0, 0}).y() - before.y(), 100, 1e-6);
}

TEST(OrbitCamera, PlacedEyeIsWhereItWasPut) {
  OrbitCamera orbit;
  orbit.frame({{0.1, 0, 0}, 1});
  const Eigen::Vector3d eye(-3, 2, 1.5);
  orbit.place(eye);
  EXPECT_NEAR((orbit.viewpoint(640, 480).eye() - eye).norm(), 0, 1e-12);
  orbit.place({0.1, 0, 0});
  EXPECT_NEAR((orbit.viewpoint(640, 480).eye() - eye).norm(), 0, 1e-12) << "an eye on the target says nothing";
}

TEST(OrbitCamera, IsUprightWhateverIsUp) {
  for (const Eigen::Vector3d& up : {Eigen::Vector3d(0, -1, 0), {0, 0, -1}, {0.6, 0, 0.8}}) {
    OrbitCamera orbit;
    orbit.frame({{1, 2, 3}, 0.5});
    orbit.set_up(up);
    const Eigen::Vector3d direction = up.unitOrthogonal();
    orbit.look_from(direction);
    const Viewpoint view = orbit.viewpoint(640, 480);
    EXPECT_NEAR((view.eye() - Eigen::Vector3d(1, 2, 3)).normalized().dot(direction), 1, 1e-12);
    const Eigen::Vector3d up_in_picture = view.camera_from_object.rotation * up;
    EXPECT_NEAR(up_in_picture.y(), -1, 1e-12);
  }
}

TEST(OpeningView, IsThatOfACameraAndTheirUp) {
  const Eigen::Vector3d centre(1, 0, 0), up(0, -1, 0);
  std::vector<PosedCamera> cameras;
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < 9; ++i) {
    const double turn = 0.2 * (i - 4), lean = 0.2 + 0.05 * (i % 3);
    directions.push_back(
        Eigen::Vector3d(std::cos(lean) * std::sin(turn), -std::sin(lean), std::cos(lean) * std::cos(turn)));
    cameras.push_back({{}, look_at(centre + 2 * directions.back(), centre, up)});
  }
  const std::optional<OpeningView> view = opening_view(cameras, centre);
  ASSERT_TRUE(view);
  EXPECT_GT(view->up.dot(up), 0.9);
  EXPECT_LT(std::abs(view->direction.x()), 0.25) << "from the middle of them";
  EXPECT_TRUE(std::any_of(directions.begin(), directions.end(),
                          [&](const Eigen::Vector3d& d) { return d.isApprox(view->direction, 1e-9); }));

  cameras.resize(2);
  cameras[1] = {{}, look_at(centre + Eigen::Vector3d(0, 0, 2), centre, -up)};
  EXPECT_GT(opening_view(cameras, centre)->up.z(), 0.99) << "they do not agree";
  EXPECT_FALSE(opening_view({}, centre));
}

TEST(Guidance, SpeaksInTheDirectionsOfTheCamerasPicture) {
  const Rigid3 camera = look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1});
  const double a = 30 * M_PI / 180;
  // From +x, looking at the origin with z up, +y is on the right.
  const Guidance right = guide(camera, {0, 0, 0}, {3 * std::cos(a), 3 * std::sin(a), 0});
  EXPECT_NEAR(right.right_deg, 30, 1e-9);
  EXPECT_NEAR(right.up_deg, 0, 1e-9);
  EXPECT_GT((camera * Eigen::Vector3d(0, 1, 0)).x(), 0) << "and so the picture says";
  const Guidance up = guide(camera, {0, 0, 0}, {std::cos(a), 0, std::sin(a)});
  EXPECT_NEAR(up.right_deg, 0, 1e-9);
  EXPECT_NEAR(up.up_deg, 30, 1e-9);
  const Guidance beyond_the_top = guide(camera, {0, 0, 0}, {-std::sin(a), 0, std::cos(a)});
  EXPECT_NEAR(std::abs(beyond_the_top.right_deg), 180, 1e-9) << "nobody climbs over the object";
  EXPECT_NEAR(beyond_the_top.up_deg, 60, 1e-9);
  const Guidance far_left = guide(camera, {0, 0, 0}, {std::cos(5 * a), -std::sin(5 * a), std::tan(a)});
  EXPECT_NEAR(far_left.right_deg, -150, 1e-9);
  EXPECT_NEAR(far_left.up_deg, 30, 1e-9);
  const Rigid3 above = look_at({0.1, 0, 2}, {0, 0, 0}, {-1, 0, 0});
  const Guidance down = guide(above, {0, 0, 0}, {1, 0, std::sqrt(3)});
  EXPECT_NEAR(down.right_deg, 0, 1e-9) << "from above by the shortest way";
  EXPECT_NEAR(down.up_deg, -(30 - std::atan2(0.1, 2) * 180 / M_PI), 1e-9);
  const Guidance here = guide(camera, {0, 0, 0}, {5, 0, 0});
  EXPECT_NEAR(std::hypot(here.right_deg, here.up_deg), 0, 1e-9);
  const Guidance behind = guide(camera, {0, 0, 0}, {-1, 0, 0});
  EXPECT_NEAR(std::hypot(behind.right_deg, behind.up_deg), 180, 1e-9);
}

TEST(Guidance, IsSaidInWords) {
  EXPECT_EQ(in_words({-35, 10.4}), "35 degrees to the left, 10 up");
  EXPECT_EQ(in_words({12, -7}), "12 degrees to the right, 7 down");
  EXPECT_EQ(in_words({20, 0.4}), "20 degrees to the right");
  EXPECT_EQ(in_words({0.4, -20}), "20 degrees down");
  EXPECT_EQ(in_words({2, -3}), "here, hold still");
  EXPECT_EQ(advice_in_words({20, 0.4}, "no image from near here"),
            "move 20 degrees to the right: no image from near here");
  EXPECT_EQ(advice_in_words({2, -3}, ""), "here, hold still");
}

TEST(ViewAction, EachHasAKeyOfItsOwn) {
  std::set<int> keys;
  for (const ActionWords& words : view_actions()) {
    EXPECT_TRUE(keys.insert(words.key).second) << words.key;
    EXPECT_EQ(action_of_key(words.key), words.action);
    EXPECT_EQ(words_of(words.action).button, words.button);
  }
  EXPECT_FALSE(action_of_key('?'));
}

TEST(ViewAction, ChangesWhatItsButtonShows) {
  for (const ActionWords& words : view_actions()) {
    ViewControls controls;
    controls.mode = ViewMode::kBytes;
    const bool was = words.action != ViewAction::kDemand && is_on(words.action, controls);
    if (apply(words.action, controls) && words.action != ViewAction::kReset && words.action != ViewAction::kGround &&
        words.action != ViewAction::kPanels) {
      EXPECT_NE(is_on(words.action, controls), was) << words.button;
    }
  }
  ViewControls controls;
  for (const ViewMode mode : {ViewMode::kRank, ViewMode::kResolution, ViewMode::kBytes, ViewMode::kRank}) {
    EXPECT_TRUE(apply(ViewAction::kDemand, controls));
    EXPECT_EQ(controls.mode, mode);
  }
}

TEST(Ground, TheLastIsFollowedByTheFirst) {
  std::set<std::vector<float>> colors;
  Ground ground = Ground::kDark;
  do {
    const Eigen::Vector3f color = color_of(ground);
    EXPECT_TRUE(colors.insert({color.x(), color.y(), color.z()}).second);
    ground = next(ground);
  } while (ground != Ground::kDark);
  EXPECT_EQ(colors.size(), 5u);
}

TEST(NeedColor, WhatIsKnownIsGreenAndWhatIsNotIsRed) {
  const auto leads = [](const Eigen::Vector3f& color, int channel) {
    return color[channel] > 1.5f * std::max(color[(channel + 1) % 3], color[(channel + 2) % 3]);
  };
  EXPECT_TRUE(leads(need_color(0), 1));
  EXPECT_TRUE(leads(need_color(1), 0));
  EXPECT_GT(need_color(0).maxCoeff(), 0.5f) << "not dark";
  EXPECT_TRUE(need_color(-1).isApprox(need_color(0)));
}

TEST(ViewMode, NamesRoundTrip) {
  for (const ViewMode mode : {ViewMode::kAppearance, ViewMode::kHeuristic, ViewMode::kSplit, ViewMode::kCamera,
                              ViewMode::kRank, ViewMode::kResolution, ViewMode::kBytes})
    EXPECT_EQ(view_mode_from(to_string(mode)), mode);
  EXPECT_FALSE(view_mode_from("Split"));
  EXPECT_FALSE(view_mode_from(""));
}

TEST(ViewerFeed, TheLatestWinsAndIsNeverTorn) {
  ViewerFeed feed;
  EXPECT_NE(feed.latest(), nullptr);
  std::jthread writer([&] {
    for (std::uint64_t i = 1; i <= 2000; ++i) {
      ViewerState state;
      state.figures = CaptureFigures{.frames_received = i, .frames_accepted = i};
      state.message = std::to_string(i);
      feed.publish(std::move(state));
    }
  });
  std::uint64_t last = 0;
  while (last < 2000) {
    const auto state = feed.latest();
    if (!state->figures) continue;
    ASSERT_GE(state->figures->frames_received, last);
    ASSERT_EQ(state->message, std::to_string(state->figures->frames_accepted));
    last = state->figures->frames_received;
  }
}

}  // namespace
}  // namespace sheen
