// SPDX-License-Identifier: Apache-2.0
// A model that nothing outside its own folder knows is served, saved, reopened, rendered, drawn, evaluated, undone.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/files.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "common/session/session.h"
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
  Json build(const fs::path& session, const fs::path& out, const Words& more = {}) const {
    const fs::path report = temp_.path() / "build.json";
    expect_outcome(run_to_end(program({"build", session, "--mesh", data_.mesh(), "--config", scene(), "--out", out,
                                       "--json", report}) +
                              more),
                   0, {"images added to the model"});
    return Json::parse(read_file(report));
  }
  static Json colours_of(const fs::path& model) { return Json::parse(read_file(model / "model.json"))["colours"]; }
  /// Colours of the model of a session that never had this capture.
  Json colours_without(std::uint64_t capture) const {
    const fs::path never = temp_.path() / "never", model = temp_.path() / "never_saw";
    {
      const Session all = Session::open_read_only(session_);
      Session session = Session::create(never);
      for (std::uint64_t i = 0; i < all.size(); ++i)
        if (i != capture) session.append(all.read(i));
    }
    build(never, model);
    return colours_of(model);
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

TEST_F(SecondModel, FilesAndTheLiveCaptureGiveTheSameBits) {
  serve_all();
  const fs::path again = temp_.path() / "again";
  build(session_, again);
  EXPECT_EQ(colours_of(again), colours_of(model_));
}

/// Pixels of a linear picture that are wholly covered, and how many of them have one of these colours.
std::pair<int, int> covered_and_of(const ExrFile& picture, const Json& colours) {
  const ImageF& image = picture.parts.at(0).image;
  int covered = 0, found = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      if (image.channels() == 4 && image.at(x, y, 3) < 1) continue;
      if (image.at(x, y, 0) + image.at(x, y, 1) + image.at(x, y, 2) <= 0) continue;
      ++covered;
      found += std::any_of(colours.begin(), colours.end(), [&](const Json& c) {
        float off = 0;
        for (int k = 0; k < 3; ++k) off = std::max(off, std::abs(image.at(x, y, k) - c[k].get<float>()));
        return off < 2e-3f;
      });
    }
  return {covered, found};
}

TEST_F(SecondModel, IsRenderedInItsOwnColours) {
  serve_all();
  const fs::path pictures = temp_.path() / "pictures";
  expect_outcome(
      run_to_end(program({"render", model_, "--cameras", data_.folder / "transforms.json", "--out", pictures})), 0,
      {"16 views rendered"});
  int files = 0;
  for (const auto& entry : fs::directory_iterator(pictures)) {
    if (entry.path().extension() != ".exr") continue;
    const auto [covered, found] = covered_and_of(read_exr(entry.path()), colours_of(model_));
    EXPECT_GT(covered, 1000) << entry.path();
    EXPECT_GT(found, 0.9 * covered) << entry.path() << ": but for the outline's pixels";
    ++files;
  }
  EXPECT_EQ(files, 16);
}

TEST_F(SecondModel, IsDrawnByItsOwnDrawer) {
  serve_all();
  const auto shown = [&](const Words& how) {
    const fs::path picture = temp_.path() / "window.png";
    const Outcome outcome =
        run_to_end(Words{SHEEN_WITH_XVFB} +
                   program({"view", model_, "--screenshot", picture, "--clean", "--size", "200x160"}) + how);
    if (outcome.output.find("without a display") != std::string::npos) return ImageU8();
    expect_outcome(outcome, 0, {});
    return to_srgb8(to_linear_rgb(read_image(picture)));
  };
  const ImageU8 appearance = shown({}), needs = shown({"--mode", "heuristic"});
  if (appearance.empty()) GTEST_SKIP() << "no Xvfb here";
  int coloured = 0, others = 0;
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 200; ++x) {
      const bool warm = appearance.at(x, y, 0) > 90 && appearance.at(x, y, 0) > appearance.at(x, y, 2) + 20;
      coloured += warm;
      others += warm && (needs.at(x, y, 0) != appearance.at(x, y, 0) || needs.at(x, y, 2) != appearance.at(x, y, 2));
    }
  EXPECT_GT(coloured, 200) << "the ball's pattern";
  EXPECT_GT(others, coloured / 2) << "where images are needed is another picture";
}

TEST_F(SecondModel, AnImageIsTakenBackAndPutBack) {
  serve_all();
  const fs::path without = temp_.path() / "without", restored = temp_.path() / "restored";
  expect_outcome(run_to_end(program({"undo", session_, "--capture", "5"})), 0, {"capture 5 is withdrawn"});
  EXPECT_EQ(build(session_, without)["frames"]["withdrawn"], 1);
  EXPECT_EQ(colours_of(without), colours_without(5));
  EXPECT_NE(colours_of(without), colours_of(model_));
  expect_outcome(run_to_end(program({"undo", session_, "--restore", "--capture", "5"})), 0, {"capture 5 is put back"});
  build(session_, restored);
  EXPECT_EQ(colours_of(restored), colours_of(model_));
}

// The whole of it at once: window and status page of a live capture, from which images are taken, the first too.
TEST_F(SecondModel, IsSeenLiveWhileImagesAreTakenBack) {
  const std::string address = free_address(), url = "http://127.0.0.1:" + std::to_string(free_port());
  const fs::path report = temp_.path() / "live.json";
  Process desk(Words{SHEEN_WITH_XVFB} +
               program({"serve", "--mesh", data_.mesh(), "--session", session_, "--config", scene(), "--endpoint",
                        address, "--json", report, "--monitor-port", url.substr(url.rfind(':') + 1)}));
  expect_outcome(run_to_end(tracker({"run", "--source", "dataset:" + data_.folder.string(), "--endpoint", address})), 0,
                 {"16 keyframes sent"});
  for (const char* capture : {"0", "5"})
    expect_outcome(run_to_end(program({"undo", session_, "--capture", capture})), 0, {"is withdrawn"});
  const Words watch = program({"monitor", "--url", url, "--json", "--once"});
  Json status;
  for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
    const Outcome outcome = run_to_end(watch);
    if (outcome.end.status != 0) continue;
    status = Json::parse(outcome.output);
    if (status["frames"]["accepted"] == 12 && status["frames"]["withdrawn"] == 2) break;
  }
  EXPECT_EQ(status["model"], "flat_colour");
  EXPECT_EQ(status["frames"]["accepted"], 12) << status.dump(1);
  desk.signal(SIGINT);
  const Outcome outcome = wait_to_end(desk);
  expect_outcome(outcome, 0, {"12 images added to the model"});
  EXPECT_EQ(Json::parse(read_file(report))["frames"]["withdrawn"], 2);
  const fs::path again = temp_.path() / "again";
  build(session_, again);
  EXPECT_EQ(colours_of(again), colours_of(model_)) << "as files without those images give";
}

TEST_F(SecondModel, KeepsBudgetAndMemoryAsItSees) {
  serve_all();
  const Json built = build(session_, temp_.path() / "quick", {"--budget", "0.001ms", "--memory", "1GB"});
  EXPECT_EQ(built["settings"]["effort_level"], 1) << "there is no quicker one";
  EXPECT_EQ(built["settings"]["budget"]["holds"], false) << built["settings"].dump(1);
  EXPECT_EQ(built["settings"]["memory"]["holds"], true) << built["settings"].dump(1);
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
