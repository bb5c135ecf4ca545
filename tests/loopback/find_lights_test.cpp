// SPDX-License-Identifier: Apache-2.0
// `lights` as a user has it: what it finds in images is a list that `build` takes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/datasets/light_list.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"
#include "tests/tracker/lights/chrome_ball_scene.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

void write_image(const fs::path& file, const ImageF& light) {
  ImageF rgb(light.width(), light.height(), 3);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb.data()[i] = light.data()[i / 3];
  write_png(file, to_srgb8(rgb));
}

TEST(FindLights, ABallInTheImagesMakesAListForBuild) {
  const TempFolder temp;
  const ChromeBallScene scene{.width = 240, .height = 180, .centre = {130.4, 88.2}, .radius = 31.3};
  const std::vector<FarLamp> lamps = lamps_on_dome(9, 25);
  const fs::path images = temp.path() / "images", list = temp.path() / "lights/dirs.lp",
                 report = temp.path() / "ball.json";
  fs::create_directories(images);
  fs::create_directories(list.parent_path());
  for (std::size_t i = 0; i <= lamps.size(); ++i) {
    const std::vector<FarLamp> lit(lamps.begin() + static_cast<std::ptrdiff_t>(i),
                                   lamps.begin() + std::ptrdiff_t(std::min(i + 1, lamps.size())));
    write_image(images / (std::string(1, static_cast<char>('a' + i)) + ".png"),
                scene.image(lit, static_cast<unsigned>(i)));
  }
  expect_outcome(run_to_end(tracker({"lights", "ball", images, "--out", list, "--json", report})), 0,
                 {"ball: x 130", "left out: j.png: no_highlight", "9 of 10 lights"});
  const Json found = Json::parse(read_file(report));
  EXPECT_EQ(found["found"], 9);
  EXPECT_EQ(found["images"][9]["refusal"], "no_highlight");
  const LightList lights = load_light_list(list);
  ASSERT_EQ(lights.views.size(), lamps.size());
  for (std::size_t i = 0; i < lamps.size(); ++i)
    EXPECT_LT(angle_deg(lights.views[i].light.position, lamps[i].towards), 1) << lights.views[i].name;
  expect_outcome(run_to_end(reconstructor({"build", list, "--model", "irradiance-field", "--out", temp.path() / "m.rif",
                                           "--bytes", "60kB"})),
                 0, {"9 images added to the model"});

  expect_outcome(run_to_end(tracker({"lights", "ball", images, "--out", list, "--ball", "130,88,33"})), 0, {"9 of 10"});
  expect_outcome(run_to_end(tracker({"lights", "ball", images, "--out", list, "--ball", "20,150,15"})), 1, {"no ball"});
  expect_outcome(run_to_end(tracker({"lights", "ball", images, "--out", list, "--ball", "20,150"})), 2, {"X,Y,RADIUS"});
  expect_outcome(run_to_end(tracker({"lights", "ball", images, "--out", temp.path() / "dirs.txt"})), 2, {".lp"});
  expect_outcome(run_to_end(tracker({"lights", "ball", temp.path() / "none", "--out", list})), 1, {"none"});
  expect_outcome(run_to_end(tracker({"lights", "--help"})), 0, {"ball", "shadows"});
}

TEST(FindLights, ShadowsAndWhatCastsThemMakeAList) {
  const TempFolder temp;
  const auto write = [&](const char* name, double near_height) {
    Json lights = Json::array();
    for (const auto& [image, lamp] :
         {std::pair{"a.png", std::array{0.3, 0.1, near_height}}, {"b.png", std::array{-0.2, 0.4, 0.8}}}) {
      Json pairs = Json::array();
      for (const auto& object :
           {std::array{0.1, 0.0, 0.1}, {-0.1, 0.05, 0.08}, {0.0, -0.12, 0.06}, {0.02, 0.1, 0.09}}) {
        const double part = object[2] / (lamp[2] - object[2]);
        Json shadow = Json::array(), top = Json::array();
        for (int k = 0; k < 3; ++k) {
          top.push_back(1e3 * object[std::size_t(k)]);
          shadow.push_back(1e3 * (object[std::size_t(k)] + part * (object[std::size_t(k)] - lamp[std::size_t(k)])));
        }
        pairs.push_back({{"shadow", shadow}, {"object", top}});
      }
      lights.push_back({{"image", image}, {"pairs", pairs}});
    }
    return temp.write(
        name,
        Json{{"format", "sheen-shadows"}, {"version", 1}, {"unit", "mm"}, {"uncertainty", 0.3}, {"lights", lights}}
            .dump());
  };
  const fs::path list = temp.path() / "lamps.lp", report = temp.path() / "lamps.json";
  expect_outcome(run_to_end(tracker({"lights", "shadows", write("near.json", 0.7), "--out", list, "--json", report})),
                 0, {"a.png: a lamp at 0.3000 0.1000 0.7000 m", "4 pairs"});
  const std::vector<LitView> near = load_lights(list);
  ASSERT_EQ(near.size(), 2u);
  EXPECT_LT((near[0].light.position - Eigen::Vector3d(0.3, 0.1, 0.7)).norm(), 1e-6);
  EXPECT_LT((near[1].light.position - Eigen::Vector3d(-0.2, 0.4, 0.8)).norm(), 1e-6);
  EXPECT_GT(Json::parse(read_file(report))["lights"][0]["position_uncertainty_m"], 0);
  expect_outcome(run_to_end(tracker({"lights", "shadows", write("far.json", 90), "--out", list})), 0,
                 {"all lights are written as directions, because a.png has no known distance", "nearly parallel",
                  "directional: another light"});
  for (const LitView& view : load_lights(list)) EXPECT_EQ(view.light.kind, LightKind::kDirectional);
  const fs::path pixels = temp.write("pixels.json", R"({"format": "sheen-shadows", "version": 1, "lights": [
      {"image": "a.png", "pairs": [{"shadow": [1, 2], "object": [3, 4]}, {"shadow": [5, 2], "object": [3, 9]}]}]})");
  expect_outcome(run_to_end(tracker({"lights", "shadows", pixels, "--out", list})), 2, {"--mesh"});
  expect_outcome(run_to_end(tracker({"lights", "shadows", temp.path() / "no.json", "--out", list})), 1,
                 {"no.json", "does not exist"});
}

}  // namespace
}  // namespace sheen::testing
