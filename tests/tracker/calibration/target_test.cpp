// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>
#include <set>

#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/stage/tag_pattern.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"
#include "tests/support/temp_folder.h"
#include "tests/tracker/calibration/synthetic_target.h"
#include "tracker/calibration/calibration_study.h"
#include "tracker/calibration/image_set.h"
#include "tracker/calibration/target_finder.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

constexpr double kInk = 30, kPaper = 200;

TEST(Target, IsReadFromItsName) {
  const CalibrationTarget chessboard = parse_target("chessboard:9x6:25mm");
  ASSERT_EQ(chessboard.points.size(), 54u);
  EXPECT_LT((chessboard.points[9 + 2] - Eigen::Vector3d(0.05, 0.025, 0)).norm(), 1e-12);
  const CalibrationTarget charuco = parse_target("charuco:7x5:3cm:22mm:DICT_5X5_100");
  EXPECT_EQ(charuco.points.size(), 24u);
  EXPECT_EQ(charuco.dictionary, "DICT_5X5_100");
  const CalibrationTarget grid = parse_target("aprilgrid:6x4:24mm:0.25");
  ASSERT_EQ(grid.points.size(), 96u);
  EXPECT_EQ(grid.point_name(4 * 7 + 2), "tag 7 corner 2");
  EXPECT_LT((grid.points[4 * 7 + 3] - Eigen::Vector3d(0.03, 0.03, 0)).norm(), 1e-12);
}

TEST(Target, SaysWhatIsWrongWithItsName) {
  for (const auto& [text, word] :
       std::vector<std::pair<std::string, std::string>>{{"chess:9x6:25mm", "no kind of target"},
                                                        {"chessboard:9x6", "a part is missing"},
                                                        {"chessboard:9:25mm", "two numbers"},
                                                        {"chessboard:9x2:25mm", "from 3 to 100"},
                                                        {"chessboard:9x6:25", "25"},
                                                        {"chessboard:9x6:25km", "25km"},
                                                        {"charuco:7x5:30mm:30mm", "smaller than its square"},
                                                        {"aprilgrid:30x30:24mm:0.3", "587"},
                                                        {"aprilgrid:6x6:24mm:-1", "gap"},
                                                        {"stage:", "file"}})
    expect_error<ConfigError>([&] { parse_target(text); }, {"--target", word});
  expect_error<ConfigError>([] { TargetFinder finder(parse_target("charuco:7x5:30mm:22mm:DICT_7")); },
                            {"DICT_7", "DICT_4X4_250"});
  expect_error<ConfigError>([] { TargetFinder finder(parse_target("charuco:15x15:30mm:22mm:DICT_4X4_50")); },
                            {"112 markers"});
}

/// Distances of what the finder finds from where the points are; `outline` lies in the image with them. A chessboard
/// may be numbered from either end.
struct Errors {
  std::size_t found = 0;
  double rms_px = 0, worst_px = 0;
};
Errors errors_of(const CalibrationTarget& target, std::span<const Eigen::Vector3d> outline, bool z_up,
                 const std::function<double(double, double)>& level, int views) {
  const Camera camera = testing::ordinary_camera();
  const TargetFinder finder(target);
  std::mt19937 rng(11);
  Errors errors;
  double sum = 0;
  for (int view = 0; view < views; ++view) {
    const Rigid3 pose = testing::random_target_pose(
        camera, outline, rng, {.most_tilt_deg = 35, .most_distance = 1.2, .spread = 0.2, .z_up = z_up});
    const ImageU8 image = testing::render_plane(camera, pose, level);
    const auto found = finder.find({image, image}, &camera);
    const auto error = [&](const TargetSighting& s, bool turned) {
      const std::size_t i = turned ? target.points.size() - 1 - std::size_t(s.point) : std::size_t(s.point);
      return (s.pixel - *camera.project(pose * target.points[i])).norm();
    };
    const bool turned = target.kind == TargetKind::kChessboard && !found.empty() && error(found[0], false) > 10;
    for (const TargetSighting& s : found) {
      sum += std::pow(error(s, turned), 2);
      errors.worst_px = std::max(errors.worst_px, error(s, turned));
      ++errors.found;
    }
  }
  errors.rms_px = std::sqrt(sum / static_cast<double>(errors.found));
  return errors;
}

std::vector<Eigen::Vector3d> rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}};
}

TEST(TargetFinder, FindsTheCornersOfAChessboard) {
  const CalibrationTarget target = parse_target("chessboard:9x6:25mm");
  const auto level = [](double x, double y) {
    const int column = static_cast<int>(std::floor(x / 0.025)), row = static_cast<int>(std::floor(y / 0.025));
    const bool board = column >= -1 && column < 9 && row >= -1 && row < 6;  // the outer squares, too
    return board && (column + row) % 2 == 0 ? kInk : kPaper;
  };
  const Errors errors = errors_of(target, rectangle(-0.03, -0.03, 0.23, 0.155), false, level, 4);
  EXPECT_EQ(errors.found, 4 * target.points.size());
  EXPECT_LT(errors.rms_px, 0.06);
  EXPECT_LT(errors.worst_px, 0.2);
}

/// Grey of a ChArUco board by its description: markers in the white squares, numbered row by row from the upper left.
/// The origin is the first inner corner.
std::function<double(double, double)> charuco_board(int columns, int rows, bool begins_white,
                                                    const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  constexpr int kMarker = 66;
  std::vector<cv::Mat> markers(static_cast<std::size_t>(columns * rows));
  int id = 0;
  for (int square = 0; square < columns * rows; ++square)
    if (((square % columns + square / columns) % 2 == 0) == begins_white)
      cv::aruco::drawMarker(dictionary, id++, kMarker, markers[square]);
  return [=](double x, double y) {
    const double u = x / 0.03 + 1, v = y / 0.03 + 1;
    const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
    if (column < 0 || column >= columns || row < 0 || row >= rows) return kPaper;
    const cv::Mat& marker = markers[row * columns + column];
    if (marker.empty()) return kInk;
    const double side = 22.0 / 30, edge = (1 - side) / 2;
    const auto cell = [&](double part) { return static_cast<int>(std::floor((part - edge) / side * kMarker)); };
    const int mx = cell(u - column), my = cell(v - row);
    if (mx < 0 || mx >= kMarker || my < 0 || my >= kMarker) return kPaper;
    return marker.at<std::uint8_t>(my, mx) > 127 ? kPaper : kInk;
  };
}

/// OpenCV began boards of an even number of rows with a white square before 4.6, and begins all with a black one since.
TEST(TargetFinder, FindsTheCornersOfACharucoBoardOfEitherLayout) {
  struct Case {
    int columns, rows;
    bool begins_white;
    const char* dictionary;
    int opencv;
  };
  for (const Case& c : {Case{7, 5, false, "DICT_4X4_250", cv::aruco::DICT_4X4_250},
                        {7, 10, true, "DICT_4X4_250", cv::aruco::DICT_4X4_250},
                        {7, 10, false, "DICT_4X4_250", cv::aruco::DICT_4X4_250},
                        {6, 8, true, "DICT_5X5_100", cv::aruco::DICT_5X5_100},
                        {8, 6, false, "DICT_6X6_50", cv::aruco::DICT_6X6_50}}) {
    const std::string name =
        "charuco:" + std::to_string(c.columns) + "x" + std::to_string(c.rows) + ":30mm:22mm:" + c.dictionary;
    SCOPED_TRACE(name + (c.begins_white ? " white" : " black"));
    const CalibrationTarget target = parse_target(name);
    const double right = 0.03 * (c.columns - 1), bottom = 0.03 * (c.rows - 1);
    const Errors errors =
        errors_of(target, rectangle(-0.03, -0.03, right, bottom), false,
                  charuco_board(c.columns, c.rows, c.begins_white, cv::aruco::getPredefinedDictionary(c.opencv)), 4);
    EXPECT_GE(errors.found, 4 * target.points.size() * 9 / 10);
    const double small = c.columns * c.rows > 35 ? 2 : 1;  // in the same image its squares are smaller
    EXPECT_LT(errors.rms_px, 0.08 * small);
    EXPECT_LT(errors.worst_px, small > 1 ? 1 : 0.3) << "where another layout was read it is a square";
  }
}

TEST(TargetFinder, NamesACharucoBoardThatIsAnother) {
  const Camera camera = testing::ordinary_camera();
  const auto seen_instead = [&](const std::string& name) {
    std::mt19937 rng(11);
    const TargetFinder finder(parse_target(name));
    const Rigid3 pose = testing::random_target_pose(camera, rectangle(-0.03, -0.03, 0.18, 0.27), rng,
                                                    {.most_tilt_deg = 20, .most_distance = 1.2, .spread = 0.2});
    const ImageU8 image = testing::render_plane(
        camera, pose, charuco_board(7, 10, true, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_250)));
    EXPECT_TRUE(finder.find({image, image}).empty());
    return finder.seen_instead();
  };
  EXPECT_THAT(seen_instead("charuco:10x7:30mm:22mm"), HasSubstr("as on one of 7x10"));
  EXPECT_THAT(seen_instead("charuco:9x9:30mm:22mm"), HasSubstr("not where a board of 9x9 squares has them"));
  EXPECT_EQ(seen_instead("charuco:7x10:30mm:22mm:DICT_6X6_50"), "");
}

TEST(TargetFinder, FindsTheCornersOfTags) {
  const CalibrationTarget target = parse_target("aprilgrid:6x4:24mm:0.3");
  const auto level = [&](double x, double y) {
    for (const StageTag& tag : target.tags.tags) {
      const Eigen::Vector3d& top_left = tag.corners_object[0];
      const double u = (x - top_left.x()) / 0.024, v = (top_left.y() - y) / 0.024;
      if (u < 0 || u >= 1 || v < 0 || v >= 1) continue;
      return tag_pattern(tag.id).white[static_cast<int>(v * kTagCells)][static_cast<int>(u * kTagCells)] ? kPaper
                                                                                                         : kInk;
    }
    return kPaper;
  };
  const Errors errors = errors_of(target, target.points, true, level, 4);
  EXPECT_GE(errors.found, 4 * target.points.size() * 9 / 10);
  EXPECT_LT(errors.rms_px, 0.05);
  EXPECT_LT(errors.worst_px, 0.2);
}

/// OpenCV's photographs of a chessboard; the file beside them publishes 0.39259 px for fy = fx and five coefficients.
TEST(TargetFinder, CalibratesRealPhotographsBetterThanPublished) {
  const auto folder = shared_data("calib_opencv");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const CalibrationTarget target = parse_target("chessboard:9x6:25mm");
  const TargetFinder finder(target);
  for (const char* side : {"left", "right"}) {
    SCOPED_TRACE(side);
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".jpg" && entry.path().filename().string().starts_with(side))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    const ImageSet images = find_images(files);
    std::vector<TargetView> views;
    for_each_image(images, [&](std::size_t i, const GreyImage& image) {
      views.push_back({images.names[i], finder.find(image)});
    });
    const Calibration found = calibrate(target.points, views, images.size, *find_lens_fit("brown-k3"));
    EXPECT_EQ(found.corners_used(), 13 * 54);  // none left out to look better
    EXPECT_LT(found.rms_all_px, 0.20);
    EXPECT_NEAR(found.camera.fx, 536, 5);
    if (std::string(side) == "left") EXPECT_NEAR(found.camera.cx, 342.28, 1);
  }
}

/// A pixel that paper (80 % of the light) and ink (5 %) share half and half.
TEST(ImageSet, GivesLightInProportion) {
  const TempFolder folder;
  ImageF linear(60, 40, 1, 0.8f);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 20; ++x) linear.at(x, y) = 0.05f;
    linear.at(20, y) = 0.425f;
  }
  write_png(folder.path() / "edge.png", to_srgb8(linear));
  for_each_image(find_images(std::vector{folder.path() / "edge.png"}), [](std::size_t, const GreyImage& image) {
    const auto part = [](const ImageU8& of) {
      return (of.at(20, 5) - of.at(3, 5)) / double(of.at(50, 5) - of.at(3, 5));
    };
    EXPECT_NEAR(part(image.light), 0.5, 0.01);
    EXPECT_GT(part(image.grey), 0.6);
  });
}

TEST(ImageSet, NamesWhatIsWrong) {
  const TempFolder folder;
  expect_error([&] { find_images(std::vector{folder.path()}); }, {"holds no JPEG or PNG"});
  write_png(folder.path() / "b.png", ImageU8(20, 10, 1));
  write_png(folder.path() / "a.png", ImageU8(20, 10, 1));
  const ImageSet images = find_images(std::vector{folder.path()});
  EXPECT_EQ(images.names, (std::vector<std::string>{"a.png", "b.png"}));
  EXPECT_EQ(images.size.width, 20);
  write_png(folder.path() / "c.png", ImageU8(21, 10, 1));
  expect_error([&] { find_images(std::vector{folder.path()}); }, {"c.png", "21x10", "a.png", "20x10"});
  expect_error([&] { find_images(std::vector{folder.path() / "none.png"}); }, {"none.png"});
}

}  // namespace
}  // namespace sheen
