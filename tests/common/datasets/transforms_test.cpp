// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/transforms_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/datasets/dataset.h"
#include "support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

/// Every file is there, and 200 x 100 pixels large.
const ImageFiles kAllThere{[](const std::string& name) { return std::filesystem::path("/data") / name; },
                           [](const std::filesystem::path&) {
                             return ImageSize{200, 100};
                           }};

std::vector<DatasetView> parse(const Json& json) {
  return parse_transforms("t.json", json.dump(), kAllThere);
}

/// One OpenGL camera at (1, 2, 3) that looks along the world's -x, up is +z.
Json pose_json() {
  return {{0, 0, 1, 1}, {1, 0, 0, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}};
}

Json valid() {
  return {{"camera_model", "OPENCV"},
          {"w", 640},
          {"h", 480},
          {"fl_x", 500},
          {"fl_y", 510},
          {"cx", 320},
          {"cy", 241},
          {"k1", 0.1},
          {"k2", -0.02},
          {"p1", 0.003},
          {"p2", 0.004},
          {"k3", 0.005},
          {"frames",
           {{{"file_path", "images/a.jpg"}, {"transform_matrix", pose_json()}},
            {{"file_path", "images/b.jpg"}, {"transform_matrix", pose_json()}},
            {{"file_path", "./images/c.jpg"}, {"transform_matrix", pose_json()}}}}};
}

TEST(Transforms, AxesAndPrincipalPointBecomeOpenCvs) {
  const auto views = parse(valid());
  ASSERT_EQ(views.size(), 3u);
  const DatasetView& view = views[0];
  EXPECT_EQ(view.name, "images/a.jpg");
  EXPECT_EQ(view.purpose, Purpose::kUnspecified);
  EXPECT_NEAR((camera_centre(view.camera_from_object) - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-12);
  // Ahead is -x, the image's right +y, its down -z.
  const Eigen::Vector3d point = view.camera_from_object * Eigen::Vector3d(1 - 5, 2 + 0.5, 3 - 0.25);
  EXPECT_NEAR((point - Eigen::Vector3d(0.5, 0.25, 5)).norm(), 0, 1e-12);
  EXPECT_DOUBLE_EQ(view.camera.cx, 319.5);
  EXPECT_DOUBLE_EQ(view.camera.cy, 240.5);
  EXPECT_EQ(view.camera.lens, LensModel::kOpenCv);
  EXPECT_EQ(view.camera.distortion, (std::array<double, 5>{0.1, -0.02, 0.003, 0.004, 0.005}));
}

TEST(Transforms, EveryCameraModel) {
  const auto camera = [](const Json& changes) {
    Json json = valid();
    for (const char* k : {"k1", "k2", "k3", "p1", "p2"}) json.erase(k);
    json.update(changes);
    return parse(json)[0].camera;
  };
  EXPECT_EQ(camera({{"camera_model", "PINHOLE"}}).distortion, (std::array<double, 5>{}));
  EXPECT_EQ(camera({{"camera_model", "SIMPLE_PINHOLE"}}).fx, 500);
  EXPECT_EQ(camera({{"camera_model", "SIMPLE_RADIAL"}, {"k1", 0.2}}).distortion[0], 0.2);
  EXPECT_EQ(camera({{"camera_model", "RADIAL"}, {"k1", 0.2}, {"k2", 0.3}}).distortion[1], 0.3);
  const Camera fisheye =
      camera({{"camera_model", "OPENCV_FISHEYE"}, {"k1", 0.1}, {"k2", 0.2}, {"k3", 0.3}, {"k4", 0.4}});
  EXPECT_EQ(fisheye.lens, LensModel::kFisheye);
  EXPECT_EQ(fisheye.distortion, (std::array<double, 5>{0.1, 0.2, 0.3, 0.4, 0}));
  EXPECT_EQ(camera({{"camera_model", nullptr}, {"is_fisheye", true}}).lens, LensModel::kFisheye);
  EXPECT_THROW(camera({{"camera_model", "EQUIRECTANGULAR"}}), FileError);
  expect_error([&] { camera({{"rolling_shutter", {0, 0.02, 0, 0}}}); }, {"frame 0", "rolling_shutter", "no one pose"});
  EXPECT_NO_THROW(camera({{"rolling_shutter", {0, 0, 0, 0}}}));
  expect_error([&] { camera({{"ftheta_p1", 0.001}}); }, {"frame 0", "ftheta_p1", "undistort the images"});
  expect_error([&] { camera({{"latlong", true}}); }, {"latlong"});
  expect_error([&] { camera({{"sk_x", 5.0}}); }, {"sk_x"});
  EXPECT_EQ(camera({{"sk_x", 0.0}, {"latlong", false}}).fx, 500);
}

TEST(Transforms, AngleOfViewAndSizeOfTheImage) {
  const Json json = {{"camera_angle_x", 2 * std::atan(0.5)},
                     {"frames", {{{"file_path", "train/r_0"}, {"transform_matrix", pose_json()}}}}};
  const DatasetView view = parse(json)[0];
  EXPECT_EQ(view.camera.width, 200);
  EXPECT_EQ(view.camera.height, 100);
  EXPECT_NEAR(view.camera.fx, 200, 1e-9);
  EXPECT_NEAR(view.camera.fy, 200, 1e-9);
  EXPECT_EQ(view.camera.cx, 99.5);
  EXPECT_EQ(view.camera.cy, 49.5);
}

TEST(Transforms, AFramesOwnValuesComeFirst) {
  Json json = valid();
  json["frames"][1].update({{"w", 320}, {"h", 240}, {"fl_x", 250}, {"cx", 160}, {"k1", 0}});
  const auto views = parse(json);
  EXPECT_EQ(views[0].camera.width, 640);
  EXPECT_EQ(views[1].camera.width, 320);
  EXPECT_EQ(views[1].camera.fx, 250);
  EXPECT_EQ(views[1].camera.fy, 510);
  EXPECT_EQ(views[1].camera.cx, 159.5);
  EXPECT_EQ(views[1].camera.distortion[0], 0);
  EXPECT_EQ(views[1].camera.distortion[1], -0.02);
}

TEST(Transforms, PosesStandInTheMeshsFrameWhateverATrainerIsTold) {
  Json json = valid();
  const Rigid3 before = parse(json)[0].camera_from_object;
  json["applied_transform"] = {{1, 0, 0, 5}, {0, 0, 1, 6}, {0, -1, 0, 7}};
  json["applied_scale"] = 2;
  json["orientation_override"] = "up";
  EXPECT_EQ((parse(json)[0].camera_from_object.matrix() - before.matrix()).norm(), 0);
}

TEST(Transforms, ListsDecideThePurpose) {
  Json json = valid();
  json["train_filenames"] = {"images/a.jpg"};
  json["val_filenames"] = {"images/b.jpg"};
  json["test_filenames"] = {"images/c.jpg"};  // the frame says ./images/c.jpg
  const auto views = parse(json);
  EXPECT_EQ(views[0].purpose, Purpose::kTraining);
  EXPECT_EQ(views[1].purpose, Purpose::kTraining);
  EXPECT_EQ(views[2].purpose, Purpose::kHeldOut);
  EXPECT_EQ(views[2].name, "./images/c.jpg") << "as the dataset writes it";
}

TEST(Transforms, WhatIsWrittenSaysThePurposesAndThePoints) {
  Json json = valid();
  std::vector<DatasetView> views = parse(json);
  const auto written = [&] { return Json::parse(transforms_text("/data/t.json", views, "points.ply")); };
  EXPECT_FALSE(written().contains("train_filenames")) << "nobody says";
  EXPECT_EQ(written()["ply_file_path"], "points.ply");
  for (DatasetView& view : views) view.purpose = Purpose::kTraining;
  EXPECT_EQ(written()["train_filenames"].size(), 3u);
  EXPECT_FALSE(written().contains("test_filenames"));
  const auto again = [&] { return parse_transforms("t.json", transforms_text("/data/t.json", views), kAllThere); };
  EXPECT_EQ(again()[2].purpose, Purpose::kTraining) << "and not: whichever the program holds out";
  views[1].purpose = Purpose::kHeldOut;
  EXPECT_EQ(written()["test_filenames"], Json({"images/b.jpg"}));
  EXPECT_EQ(again()[1].purpose, Purpose::kHeldOut);
}

TEST(Transforms, LightsStandInTheirFrames) {
  Json json = valid();
  json["frames"][0]["light_position"] = {1, -2, 3};
  json["frames"][1]["light_direction"] = {0, 0, 2};
  json["frames"][1]["light_rgb"] = {1, 0.5, 2};
  const std::vector<DatasetView> views = parse(json);
  EXPECT_EQ(views[0].light.kind, LightKind::kPoint);
  EXPECT_EQ(views[0].light.position, Eigen::Vector3d(1, -2, 3));
  EXPECT_EQ(views[1].light.kind, LightKind::kDirectional);
  EXPECT_EQ(views[1].light.position, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(views[1].light.rgb, Eigen::Vector3f(1, 0.5f, 2));
  EXPECT_EQ(views[2].light.kind, LightKind::kFixed);

  const TempFolder temp;
  write_transforms(temp.path() / "t.json", views);
  const std::vector<DatasetView> again = parse_transforms("t.json", read_file(temp.path() / "t.json"), kAllThere);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(again[i].light.kind, views[i].light.kind);
    EXPECT_EQ(again[i].light.position, views[i].light.position);
    EXPECT_EQ(again[i].light.rgb, views[i].light.rgb);
  }

  for (const auto& [key, value] : std::map<std::string, Json>{
           {"light_position", {1, 2}}, {"light_direction", {0, 0, 0}}, {"light_rgb", {1, 0, 1}}}) {
    Json wrong = valid();
    wrong["frames"][0][key] = value;
    expect_error([&] { parse(wrong); }, {"frame 0", key});
  }
  Json both = json;
  both["frames"][0]["light_direction"] = {0, 0, 1};
  expect_error([&] { parse(both); }, {"frame 0", "light_direction", "one of them"});
}

TEST(Transforms, OneExposureOfAllIsSaid) {
  Json json = valid();
  EXPECT_FALSE(parse(json)[0].exposure_locked);
  json["exposure_locked"] = true;
  std::vector<DatasetView> views = parse(json);
  EXPECT_TRUE(views[0].exposure_locked && views[2].exposure_locked);
  const auto again = [&] { return parse_transforms("t.json", transforms_text("/data/t.json", views), kAllThere); };
  EXPECT_TRUE(again()[2].exposure_locked);
  views[1].exposure_locked = false;
  EXPECT_FALSE(again()[0].exposure_locked) << "not of all";
  json["exposure_locked"] = "yes";
  expect_error([&] { parse(json); }, {"exposure_locked", "true or false"});
}

TEST(Transforms, MasksForAllOrSome) {
  Json json = valid();
  for (Json& frame : json["frames"]) frame["mask_path"] = "mask.png";
  EXPECT_EQ(parse(json)[2].mask_path, std::filesystem::path("/data/mask.png"));
  json["frames"][1].erase("mask_path");
  EXPECT_FALSE(parse(json)[1].mask_path);
  EXPECT_TRUE(parse(json)[2].mask_path);
}

TEST(Transforms, RoundedRotationsAreRepairedAndWrongOnesRefused) {
  Json json = valid();
  json["frames"][0]["transform_matrix"][0] = {0.0002, 0, 1.0003, 1};
  const Eigen::Matrix3d r = parse(json)[0].camera_from_object.rotation.toRotationMatrix();
  EXPECT_NEAR((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-14);
  json["frames"][0]["transform_matrix"][0] = {0.01, 0, 1, 1};
  expect_error([&] { parse(json); }, {"t.json", "frame 0", "images/a.jpg", "transform_matrix", "not orthonormal"});
  json["frames"][0]["transform_matrix"][0] = {0, 0, -1, 1};
  expect_error([&] { parse(json); }, {"frame 0", "reflection"});
}

TEST(Transforms, EveryWrongFieldIsNamed) {
  struct Case {
    const char* pointer;
    Json value;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases = {
      {"/w", -1, {"w:", "whole number"}},
      {"/w", 0.5, {"w:", "whole number"}},
      {"/w", 1e30, {"w:", "whole number"}},
      {"/w", "640", {"w:", "number"}},
      {"/w", nullptr, {"w:", "missing"}},
      {"/h", nullptr, {"h:", "missing"}},
      {"/fl_x", 0, {"fl_x must be 0.001"}},
      {"/fl_x", 1e-300, {"fl_x must be 0.001"}},
      {"/fl_y", 1e300, {"fl_y must be 0.001"}},
      {"/cx", -1e300, {"cx and cy"}},
      {"/k1", 1e300, {"distortion"}},
      {"/fl_x", Json::array(), {"fl_x:", "number"}},
      {"/k4", 0.1, {"k4:", "not 0"}},
      {"/camera_model", "FOV", {"camera_model", "FOV"}},
      {"/camera_model", "PINHOLE", {"k1:", "not 0"}},
      {"/camera_model", 3, {"camera_model:", "text"}},
      {"/frames", Json::array(), {"frames:", "at least one"}},
      {"/frames", "none", {"frames:"}},
      {"/frames/1", 7, {"frame 1", "object"}},
      {"/frames/1/file_path", nullptr, {"frame 1", "file_path", "missing"}},
      {"/frames/1/file_path", 7, {"frame 1", "file_path", "text"}},
      {"/frames/1/file_path", "images/../images/a.jpg", {"frame 1", "frame 0 again"}},
      {"/frames/1/file_path", std::string("a\0b", 3), {"frame 1", "file_path"}},
      {"/frames/1/transform_matrix", nullptr, {"frame 1 (images/b.jpg)", "transform_matrix", "missing"}},
      {"/frames/1/transform_matrix", Json::array({1, 2}), {"frame 1", "transform_matrix", "rows"}},
      {"/frames/1/transform_matrix/2", {1, 2, 3}, {"frame 1", "row 2", "4 numbers"}},
      {"/frames/1/transform_matrix/2/1", "x", {"frame 1", "row 2"}},
      {"/frames/1/transform_matrix/2/1", nullptr, {"frame 1", "row 2"}},
      {"/frames/1/transform_matrix/3/3", 2, {"frame 1", "0 0 0 1"}},
      {"/train_filenames", {"images/d.jpg"}, {"train_filenames", "images/d.jpg"}},
      {"/test_filenames", "images/a.jpg", {"test_filenames", "list"}},
      {"/test_filenames", {1}, {"test_filenames", "list"}},
  };
  for (const Case& c : cases) {
    Json json = valid();
    json[Json::json_pointer(c.pointer)] = c.value;
    SCOPED_TRACE(c.pointer + (" = " + c.value.dump()));
    expect_error([&] { parse(json); }, c.words);
  }
  Json both = valid();
  both["train_filenames"] = both["test_filenames"] = {"images/a.jpg"};
  expect_error([&] { parse(both); }, {"test_filenames", "images/a.jpg", "train_filenames"});
}

TEST(Transforms, MissingFilesAreNamed) {
  const ImageFiles none{[](const std::string&) { return std::filesystem::path(); }, nullptr};
  expect_error([&] { parse_transforms("t.json", valid().dump(), none); },
               {"t.json", "frame 0", "file_path", "no such"});
  std::vector<std::string> left_out;
  const ImageFiles one{
      [](const std::string& name) { return std::filesystem::path(name == "images/b.jpg" ? name : ""); }, nullptr,
      [&](const std::string& name, const std::string& why) { left_out.push_back(name + ": " + why); }};
  Json json = valid();
  json["test_filenames"] = {"images/c.jpg"};
  EXPECT_EQ(parse_transforms("t.json", json.dump(), one).size(), 1u) << "which the lists may still name";
  EXPECT_EQ(left_out, (std::vector<std::string>{"images/a.jpg: there is no such image",
                                                "./images/c.jpg: there is no such image"}));
}

TEST(Transforms, TextThatIsNoJson) {
  const auto refused = [](const std::string& text) {
    expect_error([&] { parse_transforms("t.json", text, kAllThere); }, {"t.json"});
  };
  refused("");
  refused("{");
  refused("[]");
  refused("null");
  refused("{\"frames\": [{\"file_path\": \"\xff\xfe\"}]}");
  refused("{\"w\": 1e999, \"frames\": []}");
  refused("{\"w\": NaN}");
  refused(std::string("{\"w\": 1\0}", 9));
  refused(std::string(200000, '['));
  std::string deep = std::string(200000, '[') + std::string(200000, ']');
  refused(deep);
  refused("{\"frames\": " + deep + "}");
  const std::string whole = valid().dump();
  for (std::size_t size = 0; size < whole.size(); size += 7) refused(whole.substr(0, size));
}

TEST(Transforms, CarriageReturnsAndAByteOrderMark) {
  std::string text = valid().dump(1);
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
  EXPECT_EQ(parse_transforms("t.json", "\xEF\xBB\xBF" + text, kAllThere).size(), 3u);
}

}  // namespace
}  // namespace sheen
