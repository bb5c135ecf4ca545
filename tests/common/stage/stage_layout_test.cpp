// SPDX-License-Identifier: Apache-2.0
#include "common/stage/stage_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>

#include "common/base/errors.h"

namespace sheen {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class StageFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("sheen_stage_") + info->name() + std::to_string(getpid()));
    fs::create_directories(folder_);
    path_ = folder_ / "stage.json";
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// The stage's JSON with one piece of text replaced, read back; the message of the error.
  std::string error_after(const std::string& from, const std::string& to) {
    save_stage(make_stage({}), path_);
    std::stringstream text;
    text << std::ifstream(path_).rdbuf();
    std::string s = text.str();
    const auto at = s.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    s.replace(at, from.size(), to);
    std::ofstream(path_) << s;
    try {
      load_stage(path_);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }
  fs::path folder_, path_;
};

TEST(MakeStage, TagsStandRoundTheBorderWithQuietZones) {
  const StageOptions options;
  const StageLayout stage = make_stage(options);
  EXPECT_EQ(stage.tags.size(), 24u);
  const double quiet = options.tag_m / 8;
  std::set<int> ids;
  for (const StageTag& a : stage.tags) {
    EXPECT_TRUE(ids.insert(a.id).second);
    EXPECT_EQ(stage.find(a.id), &a);
    for (const auto& corner : a.corners_object) {
      EXPECT_EQ(corner.z(), 0);
      EXPECT_LE(std::abs(corner.x()), options.width_m / 2 - options.margin_m - quiet + 1e-12);
      EXPECT_LE(std::abs(corner.y()), options.height_m / 2 - options.margin_m - quiet + 1e-12);
    }
    for (const StageTag& b : stage.tags) {
      if (a.id == b.id) continue;
      const Eigen::Vector3d apart = (a.corners_object[0] - b.corners_object[0]).cwiseAbs();
      EXPECT_GE(apart.maxCoeff(), options.tag_m + 2 * quiet - 1e-12) << a.id << ' ' << b.id;
    }
    const Eigen::Vector3d centre = (a.corners_object[0] + a.corners_object[2]) / 2;
    EXPECT_TRUE(std::abs(centre.x()) > 0.1 || std::abs(centre.y()) > 0.1) << "the middle is the object's";
  }
  EXPECT_EQ(stage.find(24), nullptr);
}

TEST(MakeStage, CornersRunClockwiseFromTopLeftSeenFromAbove) {
  for (const StageTag& tag : make_stage({}).tags) {
    const auto& c = tag.corners_object;
    EXPECT_LT(c[0].x(), c[1].x());
    EXPECT_EQ(c[0].y(), c[1].y());
    EXPECT_GT(c[1].y(), c[2].y());
    EXPECT_EQ(c[1].x(), c[2].x());
    EXPECT_LT(c[3].x(), c[2].x());
    EXPECT_NEAR((c[0] - c[1]).norm(), 0.036, 1e-12);
    EXPECT_NEAR((c[1] - c[2]).norm(), 0.036, 1e-12);
  }
}

TEST(MakeStage, RefusesWhatDoesNotFit) {
  EXPECT_THROW(make_stage({.width_m = 0.1}), ConfigError);
  EXPECT_THROW(make_stage({.tag_m = 0}), ConfigError);
  EXPECT_THROW(make_stage({.tag_m = std::nan("")}), ConfigError);
  EXPECT_THROW(make_stage({.height_m = std::numeric_limits<double>::infinity()}), ConfigError);
  EXPECT_THROW(make_stage({.margin_m = -0.001}), ConfigError);
  EXPECT_THROW(make_stage({.first_id = 586}), ConfigError);
  EXPECT_THROW(make_stage({.first_id = -1}), ConfigError);
}

TEST_F(StageFile, SurvivesTheRoundTripBitForBit) {
  const StageLayout stage = make_stage({.width_m = 0.417, .height_m = 0.311, .tag_m = 0.0333, .first_id = 100});
  save_stage(stage, path_);
  const StageLayout back = load_stage(path_);
  EXPECT_EQ(back.width_m, stage.width_m);
  EXPECT_EQ(back.height_m, stage.height_m);
  EXPECT_EQ(back.hash(), stage.hash());
  ASSERT_EQ(back.tags.size(), stage.tags.size());
  for (std::size_t i = 0; i < stage.tags.size(); ++i)
    EXPECT_EQ(back.tags[i].corners_object, stage.tags[i].corners_object);
}

TEST_F(StageFile, HashChangesWithIdAndPlace) {
  const StageLayout stage = make_stage({});
  StageLayout moved = stage, renamed = stage;
  moved.tags[7].corners_object[2].y() += 1e-9;
  std::swap(renamed.tags[3].id, renamed.tags[4].id);
  EXPECT_NE(moved.hash(), stage.hash());
  EXPECT_NE(renamed.hash(), stage.hash());
  StageLayout negative_zero = stage;
  negative_zero.tags[0].corners_object[0].z() = -0.0;
  EXPECT_EQ(negative_zero.hash(), stage.hash());
}

TEST_F(StageFile, ErrorsNameTheField) {
  EXPECT_THAT(error_after("\"family\"", "\"familie\""), HasSubstr("\"family\""));
  EXPECT_THAT(error_after("\"tag36h11\"", "\"tag16h5\""), HasSubstr("\"family\""));
  EXPECT_THAT(error_after("\"version\": 1", "\"version\": 2"), HasSubstr("\"version\" is 2"));
  EXPECT_THAT(error_after("\"width_m\": 0.4", "\"width_m\": \"wide\""), HasSubstr("\"width_m\""));
  EXPECT_THAT(error_after("\"width_m\": 0.4", "\"width_m\": -1"), HasSubstr("\"width_m\""));
  EXPECT_THAT(error_after("\"id\": 5", "\"id\": 4"), HasSubstr("tags[5].id"));
  EXPECT_THAT(error_after("\"id\": 5", "\"id\": 587"), HasSubstr("tags[5].id"));
  EXPECT_THAT(error_after("\"id\": 5", "\"id\": 1e99"), HasSubstr("tags[5].id"));
  EXPECT_THAT(error_after("\"corners_m\"", "\"corners\""), HasSubstr("tags[0].corners_m"));
  EXPECT_THAT(error_after("\"tags\"", "\"tag\""), HasSubstr("\"tags\" is missing"));
  EXPECT_THAT(error_after("{", "{{"), HasSubstr("not JSON"));
  EXPECT_THROW(load_stage(folder_ / "absent.json"), FileError);
  EXPECT_THROW(save_stage(make_stage({}), folder_ / "no" / "such" / "folder.json"), FileError);
}

TEST_F(StageFile, RefusesATagThatIsMirroredOrFlat) {
  StageLayout stage = make_stage({});
  std::swap(stage.tags[2].corners_object[1], stage.tags[2].corners_object[3]);
  save_stage(stage, path_);
  EXPECT_THROW(load_stage(path_), FileError);
  stage = make_stage({});
  stage.tags[2].corners_object.fill(Eigen::Vector3d(0.1, 0.1, 0));
  save_stage(stage, path_);
  EXPECT_THROW(load_stage(path_), FileError);
}

}  // namespace
}  // namespace sheen
