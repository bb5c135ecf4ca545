// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/colmap.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <sstream>
#include <vector>

#include "common/base/files.h"
#include "common/datasets/colmap_writer.h"
#include "support/expect_error.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

template <typename T>
void put(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

TEST(ColmapCameras, EveryModelInText) {
  const ColmapCameras cameras = parse_colmap_cameras_text("cameras.txt",
                                                          "# a comment\r\n\r\n"
                                                          "1 SIMPLE_PINHOLE 640 480 500 320 240\r\n"
                                                          "2 PINHOLE 640 480 500 510 320 240\n"
                                                          "3 SIMPLE_RADIAL 640 480 500 320 240 0.1\n"
                                                          "4 RADIAL 640 480 500 320 240 0.1 0.2 \n"
                                                          "5 OPENCV 640 480 500 510 320 240 0.1 0.2 0.3 0.4\n"
                                                          "6 OPENCV_FISHEYE 640 480 500 510 320 240 0.1 0.2 0.3 0.4\n"
                                                          "7 FULL_OPENCV 640 480 500 510 320 240 .1 .2 .3 .4 .5 0 0 0\n"
                                                          "9 SIMPLE_RADIAL_FISHEYE 640 480 500 320 240 0.1\n"
                                                          "10 RADIAL_FISHEYE 640 480 500 320 240 0.1 0.2");
  ASSERT_EQ(cameras.size(), 9u);
  for (const auto& [id, camera] : cameras) {
    EXPECT_EQ(camera.width, 640);
    EXPECT_EQ(camera.height, 480);
    EXPECT_EQ(camera.fx, 500);
    EXPECT_EQ(camera.cx, 319.5) << "COLMAP's first pixel centre is (0.5, 0.5)";
    EXPECT_EQ(camera.cy, 239.5);
    EXPECT_EQ(camera.lens, id == 6 || id > 8 ? LensModel::kFisheye : LensModel::kOpenCv);
  }
  EXPECT_EQ(cameras.at(1).fy, 500);
  EXPECT_EQ(cameras.at(2).fy, 510);
  EXPECT_EQ(cameras.at(3).distortion, (std::array<double, 5>{0.1, 0, 0, 0, 0}));
  EXPECT_EQ(cameras.at(5).distortion, (std::array<double, 5>{0.1, 0.2, 0.3, 0.4, 0}));
  EXPECT_EQ(cameras.at(7).distortion, (std::array<double, 5>{0.1, 0.2, 0.3, 0.4, 0.5}));
  EXPECT_EQ(cameras.at(10).distortion, (std::array<double, 5>{0.1, 0.2, 0, 0, 0}));
}

TEST(ColmapCameras, TextSaysWhatIsWrong) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    expect_error([&] { parse_colmap_cameras_text("cameras.txt", text); }, words);
  };
  refused("1 FOV 640 480 500 500 320 240 1", {"cameras.txt", "line 1", "FOV", "undistort"});
  refused("#\n1 PINHOLE 640 480 500 500 320", {"line 2", "4 parameters, not 3"});
  refused("1 PINHOLE 640 480 500 500 320 x", {"line 1", "PARAMS"});
  refused("1 PINHOLE 640 480 500 nan 320 240", {"line 1", "fy"});
  refused("1 PINHOLE -640 480 500 500 320 240", {"line 1", "width"});
  refused("1 PINHOLE 1e30 480 500 500 320 240", {"line 1", "width"});
  refused("x PINHOLE 640 480 500 500 320 240", {"line 1", "CAMERA_ID"});
  refused("1 PINHOLE 640 480 5 5 3 2\n1 PINHOLE 640 480 5 5 3 2", {"line 2", "twice"});
  refused("1 FULL_OPENCV 640 480 500 510 320 240 .1 .2 .3 .4 .5 1 0 0", {"line 1", "k4"});
}

TEST(ColmapCameras, BinaryAndHostileBinary) {
  std::string bytes;
  put<std::uint64_t>(bytes, 1);
  put<std::uint32_t>(bytes, 3);
  put<std::int32_t>(bytes, 4);  // OPENCV
  put<std::uint64_t>(bytes, 640);
  put<std::uint64_t>(bytes, 480);
  for (const double p : {500., 510., 320., 240., 0.1, 0.2, 0.3, 0.4}) put(bytes, p);
  const ColmapCameras cameras = parse_colmap_cameras_binary("cameras.bin", bytes);
  EXPECT_EQ(cameras.at(3).fy, 510);
  EXPECT_EQ(cameras.at(3).cy, 239.5);
  EXPECT_EQ(cameras.at(3).distortion[3], 0.4);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    expect_error([&] { parse_colmap_cameras_binary("cameras.bin", bytes.substr(0, size)); },
                 {"cameras.bin", "cut off"});
  std::string many = bytes;
  many.replace(0, 8, 8, '\xff');
  expect_error([&] { parse_colmap_cameras_binary("cameras.bin", many); }, {"entry 1", "cut off"});
  std::string strange = bytes;
  strange[12] = 7;  // FOV
  expect_error([&] { parse_colmap_cameras_binary("cameras.bin", strange); }, {"camera 3", "model 7"});
  std::string wide = bytes;
  wide.replace(16, 8, 8, '\xff');
  expect_error([&] { parse_colmap_cameras_binary("cameras.bin", wide); }, {"camera 3", "width"});
}

TEST(ColmapImages, TextWithEmptyPointLinesAndSpacesInNames) {
  const auto images = parse_colmap_images_text("images.txt",
                                               "# comment\n"
                                               "1 1 0 0 0 1 2 3 7 a.jpg\r\n"
                                               "\r\n"
                                               "2 0.5 0.5 0.5 0.5 4 5 6 8 a name.jpg\n"
                                               "10 20 -1 30 40 2\n"
                                               "3 1 0 0 0 0 0 0 7 last.jpg");
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images[0].name, "a.jpg");
  EXPECT_EQ(images[0].camera_id, 7u);
  EXPECT_EQ(images[1].name, "a name.jpg");
  EXPECT_EQ(images[2].name, "last.jpg");
  const Rigid3 pose = colmap_pose(images[1]);  // a third of a turn: x -> y -> z -> x
  EXPECT_NEAR((pose * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(4, 6, 6)).norm(), 0, 1e-12);
}

TEST(ColmapImages, TextSaysWhatIsWrong) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    expect_error([&] { parse_colmap_images_text("images.txt", text); }, words);
  };
  refused("1 1 0 0 0 1 2 3 7\n", {"line 1", "NAME"});
  refused("1 1 0 0 0 1 2\n", {"line 1", "TX TY TZ"});
  refused("1 1 0 0 0 1 2 3 7 a.jpg\n2 1 0 0 0 1 2 3 7 b.jpg\n", {"line 2", "two lines", "may be empty"});
  refused("1 1 0 0 0 1 2 3 7 a.jpg\n\n1 one 0 0 0 1 2 3 7 b.jpg\n", {"line 3", "QW"});
  ColmapImage image{"a", 1, {0.9, 0, 0, 0}, {0, 0, 0}};
  expect_error<Error>([&] { colmap_pose(image); }, {"unit quaternion"});
  image.rotation_wxyz = {std::nan(""), 0, 0, 0};
  EXPECT_THROW(colmap_pose(image), Error);
  image = {"a", 1, {1, 0, 0, 0}, {0, std::nan(""), 0}};
  EXPECT_THROW(colmap_pose(image), Error);
  image = {"a", 1, {1.0005, 0, 0, 0}, {0, 0, 0}};
  EXPECT_NEAR(colmap_pose(image).rotation.norm(), 1, 1e-15);
}

TEST(ColmapImages, BinaryAndHostileBinary) {
  std::string bytes;
  put<std::uint64_t>(bytes, 2);
  for (const char* name : {"a.jpg", "b.jpg"}) {
    put<std::uint32_t>(bytes, 1);
    for (const double v : {1., 0., 0., 0., 4., 5., 6.}) put(bytes, v);
    put<std::uint32_t>(bytes, 7);
    bytes += name;
    bytes += '\0';
    put<std::uint64_t>(bytes, 1);
    put(bytes, 10.);
    put(bytes, 20.);
    put<std::int64_t>(bytes, -1);
  }
  const auto images = parse_colmap_images_binary("images.bin", bytes);
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[1].name, "b.jpg");
  EXPECT_EQ(images[1].camera_id, 7u);
  EXPECT_EQ(images[1].translation, Eigen::Vector3d(4, 5, 6));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(parse_colmap_images_binary("images.bin", bytes.substr(0, size)), FileError) << size;
  std::string points = bytes;
  points.replace(8 + 4 + 56 + 4 + 6, 8, 8, '\xff');  // times 24 this would wrap round
  expect_error([&] { parse_colmap_images_binary("images.bin", points); }, {"entry 0", "points2D"});
}

DatasetView view(const std::string& name, const Camera& camera) {
  return {.name = name,
          .image_path = {},
          .mask_path = {},
          .camera = camera,
          .camera_from_object = {Eigen::Quaterniond(0.3, -0.4, 0.5, 0.7).normalized(), {0.1, -2, 1.0 / 3}},
          .light = {},
          .purpose = Purpose::kUnspecified,
          .exposure_s = {}};
}

constexpr Camera kCamera{.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 319.5, .cy = 239.25};

TEST(ColmapWriting, SaysWhatTheFormatSays) {
  const TempFolder temp;
  DatasetView still = view("left/a.png", kCamera);
  still.camera_from_object = {Eigen::Quaterniond(0, 1, 0, 0), {0.5, 0, 2}};
  const std::vector<ColouredPoint> points = {{{1, -2, 0.5}, {255, 128, 0}}};
  write_colmap(temp.path(), {still}, points);
  const auto lines = [&](const char* file) {
    std::string out, text = read_file(temp.path() / file);
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
      if (!line.starts_with('#')) out += line + "\n";
    return out;
  };
  EXPECT_EQ(lines("cameras.txt"), "1 PINHOLE 640 480 500 510 320 239.75\n");
  EXPECT_EQ(lines("images.txt"), "1 0 1 0 0 0.5 0 2 1 left/a.png\n\n");
  EXPECT_EQ(lines("points3D.txt"), "1 1 -2 0.5 255 128 0 -1\n");
  std::string binary;
  put(binary, std::uint64_t{1});
  put(binary, std::uint64_t{1});
  for (const double value : {1.0, -2.0, 0.5}) put(binary, value);
  for (const int value : {255, 128, 0}) put(binary, static_cast<std::uint8_t>(value));
  put(binary, -1.0);
  put(binary, std::uint64_t{0});
  EXPECT_EQ(read_file(temp.path() / "points3D.bin"), binary);
  EXPECT_FALSE(std::filesystem::exists(temp.path() / "test.txt")) << "nobody says what is held out";
}

TEST(ColmapWriting, IsReadAgainAsItWas) {
  Camera brown = kCamera, full = kCamera, fisheye = kCamera;
  brown.distortion = {0.1, -0.02, 1e-3, 2e-3, 0};
  full.distortion = {0.1, -0.02, 1e-3, 2e-3, 1.0 / 3};
  fisheye.lens = LensModel::kFisheye;
  fisheye.distortion = {0.1, 0.2, -0.3, 0.4};
  const TempFolder temp;
  const std::vector<DatasetView> views = {view("a.png", kCamera), view("b.jpg", brown), view("c.png", full),
                                          view("d.png", fisheye), view("e.png", brown)};
  write_colmap(temp.path(), views, {});
  const std::string text = read_file(temp.path() / "images.txt"), binary = read_file(temp.path() / "images.bin"),
                    cameras_text = read_file(temp.path() / "cameras.txt"),
                    cameras_binary = read_file(temp.path() / "cameras.bin");
  const ColmapCameras cameras = parse_colmap_cameras_text("cameras.txt", cameras_text);
  EXPECT_EQ(cameras, parse_colmap_cameras_binary("cameras.bin", cameras_binary));
  EXPECT_EQ(cameras.size(), 4u) << "equal ones are one";
  for (const auto& images : {parse_colmap_images_text("images.txt", text), parse_colmap_images_binary("b", binary)}) {
    ASSERT_EQ(images.size(), views.size());
    for (std::size_t i = 0; i < views.size(); ++i) {
      EXPECT_EQ(images[i].name, views[i].name);
      EXPECT_EQ(cameras.at(images[i].camera_id), views[i].camera) << i;
      const Rigid3 pose = colmap_pose(images[i]), truth = views[i].camera_from_object;
      EXPECT_EQ(pose.translation, truth.translation);
      EXPECT_NEAR(pose.rotation.angularDistance(truth.rotation), 0, 1e-15);
    }
  }
}

TEST(ColmapWriting, WhatItCannotHoldIsRefused) {
  const TempFolder temp;
  expect_error([&] { write_colmap(temp.path(), {}, {}); }, {"no views"});
  for (const char* name : {"a b.png", "a\n.png", ""})
    expect_error([&] { write_colmap(temp.path(), {view(name, kCamera)}, {}); }, {"images.txt", "name"});
}

}  // namespace
}  // namespace sheen
