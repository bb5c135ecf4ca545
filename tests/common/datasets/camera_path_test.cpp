// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/datasets/dataset.h"
#include "support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

/// Two cameras: at (1, 2, 3), looking along the world's -x with +z up, and straight down from (0, 0, 5).
Json valid() {
  return {{"camera_type", "perspective"},
          {"render_height", 240},
          {"render_width", 320},
          {"fps", 24},
          {"seconds", 1},
          {"is_cycle", false},
          {"keyframes", Json::array()},
          {"camera_path",
           {{{"camera_to_world", {0, 0, 1, 1, 1, 0, 0, 2, 0, 1, 0, 3, 0, 0, 0, 1}}, {"fov", 50}, {"aspect", 4.0 / 3}},
            {{"camera_to_world", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5, 0, 0, 0, 1}}, {"fov", 90}, {"aspect", 1}}}}};
}

void refused(const Json& json, const std::vector<std::string>& words) {
  expect_error([&] { parse_camera_path("path.json", json.dump()); }, words);
}

TEST(CameraPath, IsReadWhereCamerasAreToBeRendered) {
  const TempFolder folder;
  const std::vector<DatasetView> views = load_cameras(folder.write("camera_path.json", valid().dump()));
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0].name, "00000");
  EXPECT_EQ(views[1].name, "00001");
  const Camera& camera = views[0].camera;
  EXPECT_EQ(camera.width, 320);
  EXPECT_EQ(camera.height, 240);
  EXPECT_NEAR((camera_centre(views[0].camera_from_object) - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-12);
  // What lies ahead is seen in the middle; 25 degrees above it, at the upper edge of the first row.
  const auto pixel = [&](const DatasetView& view, const Eigen::Vector3d& point) {
    return *view.camera.project(view.camera_from_object * point);
  };
  EXPECT_NEAR((pixel(views[0], {-1, 2, 3}) - Eigen::Vector2d(159.5, 119.5)).norm(), 0, 1e-9);
  EXPECT_NEAR(pixel(views[0], {0, 2, 3 + std::tan(25 * M_PI / 180)}).y(), -0.5, 1e-9);
  EXPECT_GT(pixel(views[0], {0, 2.1, 3}).x(), 159.5);
  EXPECT_NEAR((pixel(views[1], {0, 5, 0}) - Eigen::Vector2d(159.5, -0.5)).norm(), 0, 1e-9);
}

TEST(CameraPath, ATransformsFileIsNone) {
  EXPECT_FALSE(parse_camera_path("t.json", R"({"frames": []})"));
  EXPECT_FALSE(parse_camera_path("t.json", "not JSON"));
  EXPECT_FALSE(parse_camera_path("t.json", "[1]"));
}

TEST(CameraPath, SaysWhatIsWrong) {
  Json json = valid();
  json["camera_type"] = "equirectangular";
  refused(json, {"path.json", "camera_type", "perspective"});
  json = valid();
  json["render_height"] = 0;
  refused(json, {"render_height"});
  json = valid();
  json.erase("render_width");
  refused(json, {"render_width", "missing"});
  json = valid();
  json["camera_path"] = Json::array();
  refused(json, {"camera_path", "at least one"});
  json = valid();
  json["camera_path"][1]["camera_to_world"].erase(15);
  refused(json, {"camera_path[1].camera_to_world", "16"});
  json = valid();
  json["camera_path"][1]["camera_to_world"][0] = 2;
  refused(json, {"camera_path[1].camera_to_world", "scale"});
  json = valid();
  json["camera_path"][0]["camera_to_world"][3] = 1e19;
  refused(json, {"camera_path[0].camera_to_world", "10^9 m"});
  json = valid();
  json["camera_path"][1]["camera_to_world"][12] = 1;
  refused(json, {"camera_path[1].camera_to_world", "0 0 0 1"});
  for (const Json& fov : {Json(0), Json(180), Json("50"), Json()}) {
    json = valid();
    json["camera_path"][1]["fov"] = fov;
    refused(json, {"camera_path[1].fov"});
  }
  json["camera_path"][1] = 7;
  refused(json, {"camera_path[1]"});
}

}  // namespace
}  // namespace sheen
