// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/stage_outline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "reconstructor/shape/object_hull.h"
#include "reconstructor/shape/shape_images.h"
#include "reconstructor/shape/stage_sightings.h"
#include "tests/reconstructor/shape/stage_photographs.h"

namespace sheen {
namespace {

const Camera kStageCamera{.width = 320, .height = 240, .fx = 330, .fy = 330, .cx = 159.5, .cy = 119.5};
const std::vector<Eigen::Vector3d> kEyes{{0.45, 0.1, 0.2}, {-0.2, 0.4, 0.35}, {0.1, -0.25, 0.5}};

struct Judged {
  double kept = 0;    ///< share of the ball's pixels that is not background
  double found = 0;   ///< share of the bare sheet's pixels that is background
  bool said = false;  ///< anything
  SheetSeen seen;
};
Judged judge(const StagePhotograph& photograph, const Eigen::Vector3d& eye, const StageLayout& stage) {
  const PosedCamera camera{kStageCamera, analytic::towards_origin(eye)};
  const StagePhotograph::Seen truth = photograph.seen_by(camera.camera, camera.camera_from_object);
  ShapeView view{.name = "view", .camera = camera, .grey = {}, .outline = {}};
  Judged judged{.seen = mark_sheet(StagePicture(stage), truth.colour, view)};
  judged.said = !view.outline.empty();
  double ball = 0, sheet = 0;
  for (int y = 0; y < kStageCamera.height; ++y)
    for (int x = 0; x < kStageCamera.width; ++x) {
      const bool background = judged.said && view.outline.at(x, y) == static_cast<int>(Outline::kBackground);
      if (truth.ball.at(x, y) != 0) {
        ball += 1;
        judged.kept += background ? 0 : 1;
      } else if (truth.bare_sheet.at(x, y) != 0) {
        sheet += 1;
        judged.found += background ? 1 : 0;
      }
    }
  judged.kept /= ball;
  judged.found /= sheet;
  return judged;
}

void expect_outlined(const StagePhotograph& photograph) {
  for (const Eigen::Vector3d& eye : kEyes) {
    const Judged judged = judge(photograph, eye, photograph.stage);
    EXPECT_GE(judged.kept, 0.99) << eye.transpose();
    EXPECT_GE(judged.found, 0.93) << eye.transpose();
  }
}

TEST(StageOutline, OfABallOnTheSheet) {
  expect_outlined({});
}

TEST(StageOutline, AShadowAndSlowLightAreTheSheetStill) {
  StagePhotograph photograph;
  photograph.light = [](const Eigen::Vector2d& place) -> Eigen::Array3d {
    const double slow = 1 + 1.2 * place.x() - 0.8 * place.y();
    const double from_shadow = (place - Eigen::Vector2d(-0.06, 0.03)).norm() - 0.05;  // soft over a centimetre
    const double shadow = std::clamp(0.5 + from_shadow / 0.02, 0.0, 1.0);
    return slow * (0.4 + 0.6 * shadow) * Eigen::Array3d::Ones();
  };
  expect_outlined(photograph);
}

TEST(StageOutline, EachViewHasAGainOfItsOwn) {
  for (const Eigen::Array3d& gain : {Eigen::Array3d(0.5, 0.42, 0.35), Eigen::Array3d(1.5, 1.2, 0.9)}) {
    StagePhotograph photograph;
    photograph.gain = gain;
    expect_outlined(photograph);
  }
}

TEST(StageOutline, ABallAsBlackAsInkIsKept) {
  StagePhotograph photograph;
  photograph.ball = [](const Eigen::Vector3d&) { return StagePhotograph::kInk; };
  for (const Eigen::Vector3d& eye : kEyes) {
    const Judged judged = judge(photograph, eye, photograph.stage);
    EXPECT_GE(judged.kept, 0.98) << eye.transpose();
    EXPECT_GE(judged.found, 0.9) << eye.transpose();
  }
}

TEST(StageOutline, ASheetThatIsPartlyOutOfTheFrame) {
  StagePhotograph photograph;
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0.2, 0.05, 0.2), Eigen::Vector3d(-0.1, 0.2, 0.22)}) {
    const Judged judged = judge(photograph, eye, photograph.stage);
    EXPECT_GE(judged.kept, 0.99) << eye.transpose();
    if (judged.said) EXPECT_GE(judged.found, 0.9) << eye.transpose();
  }
}

TEST(StageOutline, ASheetOfAnotherSizeSaysNothing) {
  for (const double size : {0.8, 1.06, 1.3}) {
    StageLayout stage = make_stage({});
    for (StageTag& tag : stage.tags)
      for (Eigen::Vector3d& corner : tag.corners_object) corner *= size;
    EXPECT_FALSE(judge({}, kEyes[2], stage).said) << size;
  }
}

/// Captures of a photograph from all round.
RefinementImages images_of(const StagePhotograph& photograph, int count) {
  RefinementImages images;
  std::vector<Capture> captures;
  for (const Eigen::Vector3d& eye : analytic::eyes(count, 0.5, 0.3)) {
    Capture capture;
    capture.camera = kStageCamera;
    capture.pose.status = PoseStatus::kGiven;
    capture.pose.camera_from_object = analytic::towards_origin(eye);
    capture.image = analytic::float_image(photograph.seen_by(kStageCamera, capture.pose.camera_from_object).colour);
    images.cameras.push_back({capture.camera, capture.pose.camera_from_object});
    captures.push_back(std::move(capture));
  }
  images.read = [captures](std::size_t i) { return captures[i]; };
  images.stage = photograph.stage;
  return images;
}

struct FoundHull {
  bool before_sheet = false;
  int outlines = 0;
  double in_ball = 0, beside_ball = 0;  ///< distance of the ball's middle, and of a place on the sheet, from the hull
};
FoundHull hull_of(const StagePhotograph& photograph, const std::optional<StageLayout>& stage) {
  RefinementImages images = images_of(photograph, 24);
  images.stage = stage;
  ShapeImages used(images, Eigen::Vector3d::Zero(), 60, nullptr);
  const Eigen::AlignedBox3d box = find_place(used).box;
  const std::vector<ShapeView> views = fine_views(used, box, 30'000);
  const ObjectHull found = find_hull(views, box);
  return {used.before_sheet, found.hull.outlines(), found.hull.distance(photograph.centre),
          found.hull.distance(photograph.centre + Eigen::Vector3d(0.07, 0.05, -0.02))};
}

TEST(StageOutline, TheHullIsTheBall) {
  const StagePhotograph photograph;
  const FoundHull found = hull_of(photograph, photograph.stage);
  EXPECT_TRUE(found.before_sheet);
  EXPECT_GE(found.outlines, 22);
  EXPECT_LT(found.in_ball, -0.9 * photograph.radius);
  EXPECT_GT(found.beside_ball, 0.01);
}

TEST(StageOutline, AnObjectAsWhiteAsThePaperIsNotEaten) {
  StagePhotograph photograph;
  photograph.ball = [](const Eigen::Vector3d&) { return StagePhotograph::kPaper; };
  const FoundHull found = hull_of(photograph, photograph.stage);
  EXPECT_FALSE(found.before_sheet) << "paper and object cannot be told apart";
  EXPECT_LT(found.in_ball, 0);
}

TEST(StageOutline, AStageThatTheImagesDoNotShowIsNotBelieved) {
  StageLayout small = make_stage({});
  for (StageTag& tag : small.tags)
    for (Eigen::Vector3d& corner : tag.corners_object) corner *= 0.2;  // the ball would not fit between its tags
  const FoundHull found = hull_of({}, small), without = hull_of({}, std::nullopt);
  EXPECT_FALSE(found.before_sheet);
  EXPECT_EQ(found.in_ball, without.in_ball);
  EXPECT_EQ(found.beside_ball, without.beside_ball);
}

TEST(StageSightings, PutTheStageTogether) {
  const StageLayout stage = make_stage({});
  StageSightings sightings;
  for (const Eigen::Vector3d& eye : kEyes) {
    Capture capture;
    capture.camera = kStageCamera;
    capture.pose.camera_from_object = analytic::towards_origin(eye);
    for (const StageTag& tag : stage.tags) {
      TagObservation seen{.id = tag.id, .used = tag.id != 3};
      for (int c = 0; c < 4; ++c)
        seen.corners[c] = *capture.camera.project(capture.pose.camera_from_object * tag.corners_object[c]);
      capture.tags.push_back(seen);
    }
    sightings.add(capture);
  }
  const StageLayout found = sightings.layout();
  EXPECT_EQ(found.tags.size(), stage.tags.size() - 1);
  EXPECT_EQ(found.find(3), nullptr);
  for (const StageTag& tag : found.tags)
    for (int c = 0; c < 4; ++c)
      EXPECT_LT((tag.corners_object[c] - stage.find(tag.id)->corners_object[c]).norm(), 1e-9) << tag.id;
}

}  // namespace
}  // namespace sheen
