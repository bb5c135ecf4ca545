// SPDX-License-Identifier: Apache-2.0
#include "common/camera/camera_file.h"

#include <gtest/gtest.h>

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
