// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/stored_images.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/datasets/dataset.h"
#include "common/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

constexpr RigMotion kAllStill{Motion::kStill, Motion::kStill};

class Stored : public ::testing::Test {
 protected:
  Stored() {
    for (const char* name : {"a.png", "b.png"}) write_png(temp_.path() / name, ImageU8(8, 6, 3, 90));
  }
  DatasetView view(const char* name, double x, const LightState& light) const {
    return {.name = name,
            .image_path = temp_.path() / name,
            .camera = {.width = 8, .height = 6, .fx = 9, .fy = 9, .cx = 3.5, .cy = 2.5},
            .camera_from_object = look_at({x, 0.2, 0.7}, {0, 0, 0}, {0, 0, 1}),
            .light = light};
  }
  RigMotion motion_of(const std::vector<DatasetView>& views) const {
    write_transforms(temp_.path() / "transforms.json", views);
    return open_stored_images(temp_.path()).motion;
  }
  static LightState lamp(double x) { return {.kind = LightKind::kPoint, .position = {x, 0, 1}}; }

  const TempFolder temp_;
};

TEST_F(Stored, AListOfLightsIsOfOneCamera) {
  const auto list = temp_.write("two.lp", "2\na.png 0 0 1\nb.png 0 0.6 0.8\n");
  const StoredImages images = open_stored_images(list);
  EXPECT_EQ(images.size, 2u);
  EXPECT_EQ(images.cameras.size(), 1u);
  EXPECT_EQ(images.motion, (RigMotion{Motion::kStill, Motion::kMoves}));
  EXPECT_EQ(images.read(1).source_session, images.session);
  EXPECT_EQ(images.read(1).light.position, Eigen::Vector3d(0, 0.6, 0.8));
}

/// Unit vectors may be the places of a dome of one metre: a person is told what they are taken for, unless the list
/// says.
TEST_F(Stored, AListThatLeavesOpenWhatItsLightsAreIsDoubtful) {
  const std::string lights = "a.png 0 0 1\nb.png 0 0.6 0.8\n";
  const StoredImages open = open_stored_images(temp_.write("open.lp", "2\n" + lights));
  EXPECT_NE(open.warning.find("open.lp: 2 lights of length 1 are taken for directions"), std::string::npos);
  EXPECT_NE(open.warning.find("\"2 positions\""), std::string::npos);
  const StoredImages dome = open_stored_images(temp_.write("dome.lp", "2 positions\n" + lights));
  EXPECT_EQ(dome.warning, "");
  EXPECT_EQ(dome.read(1).light.kind, LightKind::kPoint);
  EXPECT_EQ(open_stored_images(temp_.write("far.lp", "2 directions\n" + lights)).warning, "");
  const StoredImages near = open_stored_images(temp_.write("near.LP", "2\na.png 0 0 2\nb.png 0 1 2\n"));
  EXPECT_NE(near.warning.find("2 lights of length 2 to 2.24 are taken for places, in metres"), std::string::npos);
  EXPECT_NE(near.warning.find("\"2 directions\""), std::string::npos);
  EXPECT_EQ(open_stored_images(temp_.write("near.lp", "2 positions\na.png 0 0 2\nb.png 0 1 2\n")).warning, "");
  const StoredImages other = open_stored_images(temp_.write("dome.lp", "2\na.png 0 0 1.35\nb.png 0 0.81 1.08\n"));
  EXPECT_NE(other.warning.find("2 lights of length 1.35 are taken for places on a dome"), std::string::npos);
  EXPECT_NE(near.summary.find("2 of 2 images, 0 masks"), std::string::npos);
}

TEST_F(Stored, WhatMovesIsSeenInAllViewsOfADataSet) {
  EXPECT_EQ(motion_of({view("a.png", 0, {}), view("b.png", 0, {})}), kAllStill);
  EXPECT_EQ(motion_of({view("a.png", 0, lamp(0)), view("b.png", 0, lamp(0))}), kAllStill);
  EXPECT_EQ(motion_of({view("a.png", 0, {}), view("b.png", 0.3, {})}), (RigMotion{Motion::kMoves, Motion::kStill}));
  EXPECT_EQ(motion_of({view("a.png", 0, lamp(0)), view("b.png", 0, lamp(0.1))}),
            (RigMotion{Motion::kStill, Motion::kMoves}));
  EXPECT_EQ(motion_of({view("a.png", 0, lamp(0)), view("b.png", 0.3, lamp(0.1))}),
            (RigMotion{Motion::kMoves, Motion::kMoves}));
  EXPECT_EQ(motion_of({view("a.png", 0, lamp(0)), view("b.png", 0, {})}), (RigMotion{Motion::kStill, Motion::kMoves}));
  const StoredImages images = open_stored_images(temp_.path());
  EXPECT_EQ(images.cameras.size(), 2u);
  EXPECT_EQ(images.read(0).source_session, images.session);
}

TEST(MotionWatch, BeginsWithoutAnOpinion) {
  MotionWatch watch;
  EXPECT_EQ(watch.motion(), RigMotion{});
  watch.look({}, {});
  EXPECT_EQ(watch.motion(), kAllStill);
  EXPECT_EQ(in_words(watch.motion()), "the camera stands still and the light stands still");
}

}  // namespace
}  // namespace sheen
