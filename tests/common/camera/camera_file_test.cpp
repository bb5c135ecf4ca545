// SPDX-License-Identifier: Apache-2.0
#include "common/camera/camera_file.h"

#include <gtest/gtest.h>

#include "tests/support/camera_responses.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

TEST(CameraFile, IsReadAsItWasWritten) {
  const TempFolder folder;
  const auto file = folder.path() / "camera.json";
  for (const LensModel lens : {LensModel::kOpenCv, LensModel::kFisheye}) {
    CameraFile written{{.width = 640,
                        .height = 480,
                        .fx = 533.123456789012,
                        .fy = 534.1,
                        .cx = 319.7,
                        .cy = 241,
                        .lens = lens,
                        .distortion = {-0.1, 1.0 / 3, 0.001, -0.002, 0}},
                       0.0007};
    save_camera(written, file);
    const CameraFile read = load_camera(file);
    EXPECT_EQ(read.camera, written.camera);
    EXPECT_EQ(read.focal_uncertainty, written.focal_uncertainty);
  }
}

PhotometricCalibration sample_photometric() {
  PhotometricCalibration p{.response = "gamma", .gamma = 2.1, .black_level = 0.07, .black_level_uncertainty = 1e-4};
  p.photometry = {srgb_response(0.01), {312.25, 247.5, {-0.3, 0.05, -0.01}}, {1.7f, 1, 1.4f}, 0.96f};
  p.response_uncertainty.fill(1e-3f);
  p.reference_value = 0.9;
  p.vignette = {0.004, 1.5};
  p.white_balance = {0.001, 0, 0.002};
  return p;
}

TEST(CameraFile, WhatTheCameraMakesOfLightIsReadAsItWasWritten) {
  const TempFolder folder;
  const auto file = folder.path() / "camera.json";
  CameraFile written{{.width = 640, .height = 480, .fx = 533, .fy = 534, .cx = 319, .cy = 241}, 0.0007};
  written.photometric = sample_photometric();
  save_camera(written, file);
  const PhotometricCalibration read = load_camera(file).photometric.value();
  EXPECT_EQ(read.photometry, written.photometric->photometry);
  EXPECT_EQ(read.response, "gamma");
  EXPECT_EQ(read.gamma, 2.1);
  EXPECT_EQ(read.black_level, 0.07);
  EXPECT_EQ(read.black_level_uncertainty, 1e-4);
  EXPECT_EQ(read.response_uncertainty, written.photometric->response_uncertainty);
  EXPECT_EQ(read.reference_value, 0.9);
  EXPECT_EQ(read.vignette->worst, 0.004);
  EXPECT_EQ(read.vignette->centre_px, 1.5);
  EXPECT_EQ(read.white_balance, written.photometric->white_balance);

  written.photometric->vignette.reset();
  written.photometric->white_balance.reset();
  save_camera(written, file);
  const PhotometricCalibration response_alone = load_camera(file).photometric.value();
  EXPECT_FALSE(response_alone.vignette || response_alone.white_balance);
  EXPECT_TRUE(response_alone.photometry.vignette.none());

  written.photometric->photometry.response[100] = 0;  // falls
  save_camera(written, file);
  expect_error([&] { load_camera(file); }, {"camera.json", "photometry.response must never fall"});
}

TEST(CameraFile, NamesTheFieldThatIsWrong) {
  const TempFolder folder;
  const auto load = [&](const std::string& text) { load_camera(folder.write("camera.json", text)); };
  const std::string head =
      R"({"format":"sheen-camera","version":1,"width":640,"height":480,"fx":500,"fy":500,"cx":320)";
  expect_error([&] { load(head + "}"); }, {"camera.json", "\"cy\" is missing"});
  expect_error([&] { load(head + R"(,"cy":240,"lens":"zoom","distortion":[]})"); }, {"lens"});
  expect_error([&] { load(head + R"(,"cy":240,"lens":"opencv","distortion":[1,2,3,4,5,6]})"); }, {"distortion"});
  expect_error([&] { load(head + R"(,"cy":1e8,"lens":"opencv","distortion":[]})"); }, {"camera.cx and camera.cy"});
  expect_error([&] { load(R"({"format":"sheen-stage","version":1})"); }, {"sheen-camera"});
  expect_error([&] { load_camera(folder.path() / "none.json"); }, {"sheen-tracker calibrate"});
}

}  // namespace
}  // namespace sheen
