// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/light_list.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "common/base/errors.h"
#include "common/image/image_io.h"
#include "tests/support/shared_data.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string error_of(const std::string& text) {
  try {
    parse_light_list("dirs.lp", text);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(LightListTest, UnitVectorsAreDirections) {
  const auto views = parse_light_list("dirs.lp", "2\na.jpg 0 0.6 0.8\nb with spaces.jpg\t1e0 -0.0 +0\r\n\n");
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0].name, "a.jpg");
  EXPECT_EQ(views[0].light.kind, LightKind::kDirectional);
  EXPECT_EQ(views[0].light.position, Eigen::Vector3d(0, 0.6, 0.8).normalized());
  EXPECT_EQ(views[1].name, "b with spaces.jpg");
  EXPECT_EQ(views[1].light.position, Eigen::Vector3d(1, 0, 0));
}

TEST(LightListTest, RoundedDirectionsAreMadeUnit) {
  const auto views = parse_light_list("dirs.lp", "1\na.jpg 0.337 0.925 0.174\n");
  EXPECT_EQ(views[0].light.kind, LightKind::kDirectional);
  EXPECT_NEAR(views[0].light.position.norm(), 1, 1e-12);
}

TEST(LightListTest, OtherLengthsArePositions) {
  const auto views = parse_light_list("dirs.lp",
                                      "\xEF\xBB\xBF"
                                      "2\na.jpg 0 1 2\nb.jpg -3 4 0.5\n");
  EXPECT_EQ(views[0].light.kind, LightKind::kPoint);
  EXPECT_EQ(views[1].light.position, Eigen::Vector3d(-3, 4, 0.5));
}

TEST(LightListTest, TheFirstLineMaySayWhatTheyAre) {
  const auto dome = parse_light_list("dirs.lp", "2 positions\na.jpg 0 0.6 0.8\nb.jpg 0 0 1\n");
  for (const LitView& view : dome) EXPECT_EQ(view.light.kind, LightKind::kPoint) << "a dome of 1 m";
  EXPECT_EQ(dome[0].light.position, Eigen::Vector3d(0, 0.6, 0.8));
  const auto far = parse_light_list("dirs.lp", "2 directions\r\na.jpg 0 3 4\nb.jpg 0 0 1\n");
  for (const LitView& view : far) EXPECT_EQ(view.light.kind, LightKind::kDirectional);
  EXPECT_LT((far[0].light.position - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
  for (const char* first : {"2 lamps", "positions 2", "2 positions directions", "positions"})
    EXPECT_THAT(error_of(first + std::string("\na 0 0 1\nb 0 1 0\n")),
                AllOf(HasSubstr("must begin with a line"), HasSubstr("\"49 positions\"")));
}

/// What is written reads back as the same lights, whatever their lengths.
TEST(LightListTest, WrittenListsReadBackTheSame) {
  const auto light = [](LightKind kind, const Eigen::Vector3d& at) { return LightState{.kind = kind, .position = at}; };
  for (const auto kind : {LightKind::kPoint, LightKind::kDirectional}) {
    for (const double length : {1.0, 1.01, 0.37}) {
      std::vector<LitView> views;
      for (const Eigen::Vector3d& way : {Eigen::Vector3d(0.1, 0.2, 0.9), Eigen::Vector3d(-1.0 / 3, 0, 1e-9)}) {
        const double size = kind == LightKind::kPoint ? length : 1;
        views.push_back({"a b" + std::to_string(views.size()), light(kind, size * way.normalized())});
      }
      views.push_back({"c", light(kind, {0, 0, kind == LightKind::kPoint ? 0.5 : 1})});
      const auto again = parse_light_list("again.lp", light_list_text(views));
      ASSERT_EQ(again.size(), views.size());
      for (std::size_t i = 0; i < views.size(); ++i) {
        EXPECT_EQ(again[i].name, views[i].name);
        EXPECT_EQ(again[i].light.kind, kind) << length;
        EXPECT_LT((again[i].light.position - views[i].light.position).norm(), 1e-15);
      }
    }
  }
}

TEST(LightListTest, ANameMayHaveQuotesOfItsOwn) {
  const auto views = parse_light_list("a.lp", "3\n''a.jpg'' 0 0 1\n\"'b'\" 0 1 0\n'c 1 0 0\n");
  EXPECT_EQ(views[0].name, "'a.jpg'");
  EXPECT_EQ(views[1].name, "'b'");
  const auto again = parse_light_list("again.lp", light_list_text(views));
  for (std::size_t i = 0; i < views.size(); ++i) EXPECT_EQ(again[i].name, views[i].name);
}

TEST(LightListTest, BrokenListsAreRefusedByTheirLine) {
  EXPECT_THAT(error_of(""), HasSubstr("dirs.lp: must begin with a line that says how many images follow"));
  EXPECT_THAT(error_of("a.jpg 0 0 1\n"), HasSubstr("must begin with a line"));
  EXPECT_THAT(error_of("0\n"), HasSubstr("must begin with a line"));
  EXPECT_THAT(error_of("-1\na 0 0 1\n"), HasSubstr("must begin with a line"));
  EXPECT_THAT(error_of("99999999999999999999\n"), HasSubstr("must begin with a line"));
  EXPECT_THAT(error_of("3\na 0 0 1\n"), HasSubstr("says that 3 images follow, but has lines for 1"));
  EXPECT_THAT(error_of("1\na 0 0 1\nb 0 1 0\n"), HasSubstr("says that 1 images follow, but has lines for 2"));
  EXPECT_THAT(error_of("1\n\na 0 0 0\n"), AllOf(HasSubstr("line 3"), HasSubstr("0 0 0 has no direction")));
  EXPECT_THAT(error_of("1\na 0 0\n"), AllOf(HasSubstr("line 2"), HasSubstr("must be a name and three numbers")));
  EXPECT_THAT(error_of("1\n0 0 1\n"), HasSubstr("must begin with the name of an image"));
  EXPECT_THAT(error_of("1\na 0 0 one\n"), HasSubstr("three numbers"));
  EXPECT_THAT(error_of("1\na nan 0 1\n"), HasSubstr("three numbers"));
  EXPECT_THAT(error_of("1\na inf 0 1\n"), HasSubstr("three numbers"));
  EXPECT_THAT(error_of("1\na 1e300 0 1\n"), HasSubstr("three numbers"));
  EXPECT_THAT(error_of("1\na\x01 0 0 1\n"), HasSubstr("name of an image"));
  EXPECT_THAT(error_of("2\na 0 0 1\na 0 1 0\n"), AllOf(HasSubstr("line 3"), HasSubstr("a stands there twice")));
  EXPECT_THAT(error_of("3\na 0 0 1\nb 0 1 0\nc 0 1 1\n"),
              AllOf(HasSubstr("line 4"), HasSubstr("c"), HasSubstr("length 1.41"), HasSubstr("\"3 positions\"")));
}

class LightFolder : public ::testing::Test {
 protected:
  std::filesystem::path list(const std::string& text) const { return temp_.write("dirs.lp", text); }
  void image(const std::string& name, int width, int height) const {
    write_png(temp_.path() / name, ImageU8(width, height, 3, 100));
  }
  const TempFolder temp_;
};

TEST_F(LightFolder, ImagesAreFoundByTheLastPartOfTheirName) {
  image("a.png", 6, 4);
  image("b.png", 6, 4);
  const LightList lights = load_light_list(list("2\nC:\\rti\\a.png 0 0 1\n/home/x/b.png 0 0.6 0.8\n"));
  ASSERT_EQ(lights.images.size(), 2u);
  const Capture capture = read_capture(lights, 1);
  EXPECT_EQ(capture.name, "/home/x/b.png");
  EXPECT_EQ(capture.light.position, Eigen::Vector3d(0, 0.6, 0.8).normalized());
  EXPECT_EQ(capture.image.width, 6);
  EXPECT_TRUE(capture.pose.usable());
}

TEST_F(LightFolder, NamesOfAWindowsMachine) {
  image("a.png", 6, 4);
  image("M\xc3\xbcnze.png", 6, 4);
  const LightList lights =
      load_light_list(list("  2 \r\n\"C:\\RTI Projekte\\A.PNG\"\t0,0\t0,6\t0,8\r\n'x\\Mu\xcc\x88nze.png' 0 0 1\r\n"));
  ASSERT_EQ(lights.images.size(), 2u);
  EXPECT_EQ(lights.images[0], temp_.path() / "a.png");
  EXPECT_EQ(lights.views[0].light.position, Eigen::Vector3d(0, 0.6, 0.8).normalized());
}

TEST_F(LightFolder, MissingAndDamagedImagesAreLeftOutAndTold) {
  for (const char* name : {"a.png", "b.png", "c.png"}) image(name, 6, 4);
  temp_.write("b.png", "no picture");
  const LightList lights = load_light_list(list("4\na.png 0 0 1\nb.png 0 1 0\nc.png 1 0 0\nd.png 0 0 1\n"));
  ASSERT_EQ(lights.views.size(), 2u);
  EXPECT_EQ(lights.views[1].name, "c.png");
  EXPECT_EQ(read_capture(lights, 1).light.position, Eigen::Vector3d(1, 0, 0));
  EXPECT_THAT(in_words(lights.account, temp_.path()), AllOf(HasSubstr("2 of 4 images"), HasSubstr("left out: b.png: "),
                                                            HasSubstr("left out: d.png: there is no")));
}

/// The list's axes are the object's: x right, y up, z towards the camera.
TEST_F(LightFolder, TheCameraLooksAtTheListsAxes) {
  image("a.png", 64, 48);
  const PosedCamera posed = load_light_list(list("1\na.png 0 0 1\n")).camera;
  const auto pixel = [&](const Eigen::Vector3d& point) {
    return *posed.camera.project(posed.camera_from_object * point);
  };
  const Eigen::Vector2d middle = pixel({0, 0, 0});
  EXPECT_EQ(middle, Eigen::Vector2d(31.5, 23.5));
  EXPECT_GT(pixel({0.1, 0, 0}).x(), middle.x());
  EXPECT_LT(pixel({0, 0.1, 0}).y(), middle.y());
  EXPECT_GT(pixel({0.1, 0, 0.1}).x(), pixel({0.1, 0, 0}).x()) << "nearer to the camera is larger";
}

TEST_F(LightFolder, MissingAndUnequalImagesAreRefused) {
  image("a.png", 6, 4);
  image("b.png", 4, 6);
  const auto what = [&](const std::string& text) {
    try {
      load_light_list(list(text));
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(what("3\na.png 0 0 1\nc.png 0 1 0\nd.png 1 0 0\n"),
              AllOf(HasSubstr("only 1 of its 3 images"), HasSubstr("c.png: there is no such image")));
  EXPECT_THAT(what("2\na.png 0 0 1\nb.png 0 1 0\n"),
              AllOf(HasSubstr("b.png: is 4 x 6 pixels"), HasSubstr("a.png is 6 x 4")));
}

TEST(LightListTest, ReadsPublishedLists) {
  const auto list = shared_data("relighting") / "synthrti_object1/Multi/Object1/material1/Dome/dirs.lp";
  if (!std::filesystem::exists(list)) GTEST_SKIP() << "no " << list;
  const LightList lights = load_light_list(list);
  ASSERT_EQ(lights.views.size(), 49u);
  EXPECT_EQ(lights.camera.camera.width, 320);
  for (const LitView& view : lights.views) EXPECT_EQ(view.light.kind, LightKind::kDirectional);
  EXPECT_EQ(lights.views.back().light.position, Eigen::Vector3d(0, 0, 1));
}

}  // namespace
}  // namespace sheen
