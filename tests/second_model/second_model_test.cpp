// SPDX-License-Identifier: Apache-2.0
// A model that nothing outside its own folder knows is served, saved, reopened, rendered, drawn, evaluated, undone.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class SecondModel : public ::testing::Test {
 protected:
  SecondModel() { data_.write(); }

  static Words program(const Words& arguments) { return Words{SHEEN_TWO_MODELS} + arguments; }
  fs::path scene(const std::string& text = "model = \"flat_colour\"\n") const {
    return temp_.write("scene.toml", text);
  }
  /// Everything that the camera sent is in the session and in the model when it returns.
  Json serve_all(const Words& more = {}) const {
    const std::string address = free_address();
    const fs::path report = temp_.path() / "live.json";
    Process desk(program({"serve", "--mesh", data_.mesh(), "--session", session_, "--config", scene(), "--endpoint",
                          address, "--json", report, "--headless", "--no-monitor", "--once"}) +
                 more);
    expect_outcome(run_to_end(tracker({"run", "--source", "dataset:" + data_.folder.string(), "--endpoint", address})),
                   0, {"16 keyframes sent"});
    expect_outcome(wait_to_end(desk), 0, {"images added to the model"});
    return Json::parse(read_file(report));
  }
  void build(const fs::path& out, const Words& more = {}) const {
    expect_outcome(
        run_to_end(program({"build", session_, "--mesh", data_.mesh(), "--config", scene(), "--out", out}) + more), 0,
        {"images added to the model"});
  }

  const TempFolder temp_;
  const BallDataset data_{temp_.path() / "ball"};
  const fs::path session_ = temp_.path() / "session", model_ = session_ / "model";
};

TEST_F(SecondModel, IsServedSavedAndEvaluatedWithTheSameFigures) {
  const Json live = serve_all();
  EXPECT_EQ(live["settings"]["model"], "flat_colour");
  EXPECT_EQ(live["settings"]["pixel_stride"], 1);
  EXPECT_EQ(live["frames"]["accepted"], 14);
  EXPECT_EQ(live["held_out"]["views"], 2);
  EXPECT_GT(live["held_out"]["psnr_db"], 10) << "a pattern in 320 colours";
  EXPECT_EQ(Json::parse(read_file(model_ / "model.json"))["format"], "flat colour");

  const fs::path scores = temp_.path() / "scores.json";
  expect_outcome(run_to_end(program({"evaluate", model_, session_, "--baselines", "--json", scores})), 0,
                 {"held-out views", "flat colour (no photograph kept)"});
  const Json evaluated = Json::parse(read_file(scores));
  EXPECT_EQ(evaluated["object"]["psnr_db"], live["held_out"]["psnr_db"]);
  EXPECT_EQ(evaluated["views"], live["held_out"]["per_view"]);
}

TEST_F(SecondModel, IsRenderedAsItWasSaved) {
  serve_all();
  const fs::path pictures = temp_.path() / "pictures", again = temp_.path() / "again";
  expect_outcome(
      run_to_end(program({"render", model_, "--cameras", data_.folder / "transforms.json", "--out", pictures})), 0,
      {"16 views rendered"});
  build(again);
  EXPECT_EQ(Json::parse(read_file(again / "model.json"))["colours"],
            Json::parse(read_file(model_ / "model.json"))["colours"])
      << "files and the live capture give the same bits";
}

TEST_F(SecondModel, IsDrawnByItsOwnDrawer) {
  serve_all();
  const auto shown = [&](const Words& how) {
    const fs::path picture = temp_.path() / "window.png";
    const Outcome outcome = run_to_end(Words{SHEEN_WITH_XVFB} +
                                       program({"view", model_, "--screenshot", picture, "--size", "200x160"}) + how);
    if (outcome.output.find("without a display") != std::string::npos) return ImageU8();
    expect_outcome(outcome, 0, {});
    return to_srgb8(to_linear_rgb(read_image(picture)));
  };
  const ImageU8 appearance = shown({}), needs = shown({"--mode", "heuristic"});
  if (appearance.empty()) GTEST_SKIP() << "no Xvfb here";
  int coloured = 0, red = 0;
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 200; ++x) {
      coloured += appearance.at(x, y, 0) > 90 && appearance.at(x, y, 0) > appearance.at(x, y, 2) + 20;
      red += needs.at(x, y, 0) == 255 && needs.at(x, y, 1) == 0;
    }
  EXPECT_GT(coloured + red, 200) << "the ball's pattern, or what no image showed";
}

TEST_F(SecondModel, AnImageIsTakenBack) {
  serve_all();
  expect_outcome(run_to_end(program({"undo", session_, "--capture", "5"})), 0, {"capture 5 is withdrawn"});
  const fs::path without = temp_.path() / "without";
  build(without);
  EXPECT_NE(Json::parse(read_file(without / "model.json"))["colours"],
            Json::parse(read_file(model_ / "model.json"))["colours"]);
}

TEST_F(SecondModel, KeepsBudgetAndMemoryAsItSees) {
  serve_all();
  build(temp_.path() / "quick", {"--budget", "0.001ms", "--memory", "1GB"});
}

TEST_F(SecondModel, IsNotTakenForAnother) {
  serve_all();
  expect_outcome(run_to_end(reconstructor({"render", model_, "--cameras", data_.folder / "transforms.json", "--out",
                                           temp_.path() / "pictures"})),
                 1, {"model.json", "no model that this program knows"});
  expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", data_.mesh(), "--config", scene()})), 2,
                 {"scene.toml:1", "model must be one of", "surface_light_field"});
  expect_outcome(run_to_end(program({"tradeoff", session_, "--mesh", data_.mesh(), "--config", scene()})), 2,
                 {"tradeoff works on surface light fields", "flat_colour"});
  expect_outcome(run_to_end(program({"build", session_, "--mesh", data_.mesh(), "--config",
                                     scene("model = \"flat_colour\"\n[flat_colour]\npixel_stride = 0\n")})),
                 2, {"scene.toml:3", "pixel_stride"});
  expect_outcome(
      run_to_end(program({"build", session_, "--mesh", data_.mesh(), "--config", scene(), "--tolerance", "40dB"})), 2,
      {"flat_colour has no tolerance"});
}

}  // namespace
}  // namespace sheen::testing
