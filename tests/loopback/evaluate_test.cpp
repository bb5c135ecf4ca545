// SPDX-License-Identifier: Apache-2.0
// `evaluate` judges a saved model as `build` judged it: the same views, levels and settings.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "common/session/session.h"
#include "tests/loopback/daemons.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Two runs of a tracker, whose frames have the same names, of a camera that is set again for each image.
class Evaluate : public ::testing::Test {
 protected:
  static constexpr int kEachRun = 14;

  Evaluate() {
    save_ply(square_mesh(0.1f, 0, 8), mesh_);
    Session session = Session::create(session_);
    const std::vector<Eigen::Vector3d> eyes = analytic::eyes(2 * kEachRun, 0.5, 0.55);
    for (int i = 0; i < 2 * kEachRun; ++i) {
      // The last of a run stands where its first one stood, so that it is a repetition.
      const int place = i % kEachRun == kEachRun - 1 ? i - kEachRun + 1 : i;
      session.append(photograph(eyes[static_cast<std::size_t>(place)], i / kEachRun, i % kEachRun));
    }
  }

  static Capture photograph(const Eigen::Vector3d& eye, int run, int frame) {
    const Camera camera{.width = 160, .height = 120, .fx = 250, .fy = 250, .cx = 79.5, .cy = 59.5};
    const double exposure_s[] = {0.01, 0.02, 0.005, 0.0125, 0.008};
    analytic::Scene scene{analytic::square(0.1, 0), analytic::two_terms(0.1)};
    Capture capture;
    capture.exposure.exposure_s = exposure_s[(2 * run + frame) % 5];
    const double factor = capture.exposure.exposure_s / 0.01;
    const analytic::Radiance radiance = scene.radiance;
    scene.radiance = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
      return Eigen::Vector3d(factor * radiance(p, d));
    };
    const Exposure exposure = capture.exposure;
    capture = analytic::capture(scene, camera, analytic::towards_origin(eye));
    capture.exposure = exposure;
    capture.source_session = "run " + std::to_string(run);
    capture.sequence = static_cast<std::uint64_t>(frame + 1);
    capture.name = "frame " + std::to_string(frame + 3 * run);  // not every Nth of both by name
    return capture;
  }

  Json build(const std::string& scene, const fs::path& out, const Words& more = {"--loss", "0dB"}) const {
    const fs::path report = temp_.path() / "built.json";
    expect_outcome(
        run_to_end(reconstructor({"build", session_, "--mesh", mesh_, "--config",
                                  temp_.write("scene.toml", "[images]\n" + scene), "--out", out, "--json", report}) +
                   more),
        0, {});
    return Json::parse(read_file(report));
  }

  const TempFolder temp_;
  const fs::path session_ = temp_.path() / "session", mesh_ = temp_.path() / "square.ply",
                 model_ = temp_.path() / "model";
};

TEST_F(Evaluate, GivesTheFiguresThatBuildReportedToTheLastDigit) {
  const std::string stay = "\n[surface_light_field.advanced]\nmap_detail = 0";  // else mean colours are of other maps
  for (const std::string& keys :
       {"sampling = \"linear\"\nerosion_px = 3\nexposure = \"known\"\n[surface_light_field]\nsurface_map = 6" + stay,
        "[surface_light_field.study]\ninterpolation = \"delaunay\"" + stay, "exposure = \"estimate\"" + stay,
        "exposure = \"off\"" + stay, std::string("exposure = \"off\"")}) {
    const std::string scene = "hold_out_every = 4\n" + keys;
    const bool maps_stay = keys.find(stay) != keys.npos;
    const Json built = build(scene, model_);
    const fs::path scores = temp_.path() / "scores.json";
    expect_outcome(run_to_end(reconstructor({"evaluate", model_, session_, "--json", scores})), 0, {"held-out views"});
    const Json evaluated = Json::parse(read_file(scores));
    ASSERT_EQ(built["held_out"]["views"], 6) << scene;
    EXPECT_EQ(evaluated["views"].size(), 6u) << scene;
    if (scene.find("\"known\"") != scene.npos) {
      EXPECT_GT(built["patches"]["skipped"], 0) << "a repetition, which is no part of the mean colours";
    }
    for (const char* figure : {"psnr_db", "ssim", "psnr_pooled_db", "psnr_gain_aligned_db"})
      EXPECT_EQ(evaluated["object"][figure], built["held_out"][figure]) << figure << '\n' << scene;
    EXPECT_EQ(evaluated["views"], built["held_out"]["per_view"]) << scene;
    if (maps_stay) {
      EXPECT_EQ(evaluated["constant"]["psnr_db"], built["held_out"]["constant_psnr_db"]) << scene;
      EXPECT_EQ(evaluated["constant"]["ssim"], built["held_out"]["constant_ssim"]) << scene;
      EXPECT_EQ(evaluated["constant_views"], built["held_out"]["constant_per_view"]) << scene;
    } else {
      EXPECT_NEAR(evaluated["constant"]["psnr_db"], built["held_out"]["constant_psnr_db"].get<double>(), 0.3) << scene;
    }
    EXPECT_EQ(evaluated["predicted_error"]["calibration"], built["predicted_error"]) << scene;
    EXPECT_EQ(built["predicted_error"]["views"], 6) << scene;
    const Json model = Json::parse(read_file(model_ / "model.json"));
    const Json noted = Json::parse(model["metadata"]["error_calibration"].get<std::string>());
    EXPECT_EQ(noted["offset_db"], built["predicted_error"]["offset_db"]) << scene;
  }
}

TEST_F(Evaluate, ASmallModelLosesWhatItsReportSays) {
  const Json exact = build("hold_out_every = 4", model_);
  const fs::path small = temp_.path() / "small.slf", report = temp_.path() / "small.json";
  const auto evaluated = [&] {
    expect_outcome(run_to_end(reconstructor({"evaluate", small, session_, "--json", report})), 0, {"held-out views"});
    return Json::parse(read_file(report));
  };
  const Json built = build("hold_out_every = 4", small, {"--loss", "0.5dB"});
  EXPECT_EQ(built["file"]["bytes"], fs::file_size(small));
  EXPECT_LE(built["file"]["loss_db"], 0.5);
  const Json judged = evaluated();
  EXPECT_NEAR(exact["held_out"]["psnr_db"].get<double>() - judged["object"]["psnr_db"].get<double>(),
              built["file"]["loss_db"].get<double>(), 1e-3);
  EXPECT_TRUE(judged["predicted_error"]["calibration"]["calibrated"]);

  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small, "--bytes", "60kB", "--json", report})),
                 0, {"small.slf"});
  EXPECT_EQ(Json::parse(read_file(report))["file"]["bytes"], fs::file_size(small));
  EXPECT_NEAR(static_cast<double>(fs::file_size(small)), 60e3, 0.02 * 60e3);
  EXPECT_EQ(evaluated()["views"].size(), judged["views"].size());
}

TEST_F(Evaluate, AModelIsSmallUnlessNothingMayBeLost) {
  const auto names_beside_it = [&] {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(temp_.path()))
      if (entry.path().filename().string().starts_with("model")) names.insert(entry.path().filename());
    return names;
  };
  for (int again = 0; again < 2; ++again) {  // each takes the place of the other
    const Json small = build("hold_out_every = 4", model_, {});
    EXPECT_EQ(small["file"]["as_asked"], small["file"]["loss_db"] <= 0.1) << "0.1 dB where nothing is asked for";
    EXPECT_EQ(small["file"]["bytes"], fs::file_size(model_));
    EXPECT_EQ(names_beside_it(), std::set<std::string>{"model"});
    EXPECT_FALSE(build("hold_out_every = 4", model_).contains("file"));
    EXPECT_TRUE(fs::exists(model_ / "model.json"));
    EXPECT_EQ(names_beside_it(), std::set<std::string>{"model"});
  }
  write_file(model_ / "notes.txt", "of a person");
  expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", mesh_, "--out", model_})), 1,
                 {model_.string(), "notes.txt"});
  EXPECT_TRUE(fs::exists(model_ / "notes.txt") && fs::exists(model_ / "model.json"));
}

TEST_F(Evaluate, PhotographsMadeSmallMakeTheModelThatTheirReportSays) {
  const fs::path photographs = temp_.path() / "photographs", report = temp_.path() / "small.json";
  expect_outcome(run_to_end(reconstructor({"compress", session_, "--mesh", mesh_, "--out", photographs, "--bytes",
                                           "120kB", "--json", report})),
                 0, {"28 photographs (0 left out)", "a model of them loses", "sheen-reconstructor build"});
  const Json small = Json::parse(read_file(report))["photographs"];
  EXPECT_EQ(small["photographs"], 2 * kEachRun);
  EXPECT_LE(small["bytes"], 120e3);
  EXPECT_GT(small["bytes"], 60e3);
  const fs::path built = temp_.path() / "built.json";
  expect_outcome(run_to_end(reconstructor({"build", photographs, "--mesh", mesh_, "--json", built})), 0, {});
  // There, views are judged by their small photographs, which are as far from the truth as the model is, or farther.
  const double psnr_db = Json::parse(read_file(built))["held_out"]["psnr_db"].get<double>();
  EXPECT_GT(psnr_db, 38);
  EXPECT_LT(psnr_db, small["psnr_db"].get<double>());

  expect_outcome(run_to_end(reconstructor({"compress", session_, "--mesh", mesh_, "--out", photographs})), 1,
                 {photographs.string(), "is there already"});
  const fs::path other = temp_.path() / "other";
  expect_outcome(run_to_end(reconstructor(
                     {"compress", session_, "--mesh", mesh_, "--out", other, "--loss", "0.6dB", "--json", report})),
                 0, {"28 photographs"});
  EXPECT_LE(Json::parse(read_file(report))["photographs"]["loss_db"], 0.6);
  for (const auto& entry : fs::directory_iterator(temp_.path())) EXPECT_NE(entry.path().extension(), ".part");
  const fs::path none = temp_.path() / "none";
  expect_outcome(run_to_end(reconstructor({"compress", session_, "--mesh", mesh_, "--out", none, "--loss", "0dB"})), 2,
                 {"--loss 0dB", "photographs themselves"});
  expect_outcome(run_to_end(reconstructor({"compress", session_, "--out", none})), 2, {session_.string(), "--mesh"});
  EXPECT_FALSE(fs::exists(none));
}

TEST_F(Evaluate, WhatCannotBeMadeSmallSaysWhy) {
  build("hold_out_every = 4", model_);
  const fs::path small = temp_.path() / "small.slf";
  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small, "--bytes", "100B"})), 2,
                 {"does not fit", "the least"});
  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small, "--bytes", "many"})), 2,
                 {"--bytes many"});
  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small, "--loss", "0.1"})), 2, {"--loss 0.1"});
  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small, "--loss", "0.1dB", "--bytes", "1MB"})),
                 2, {"--loss"});
  expect_outcome(run_to_end(reconstructor({"compress", temp_.path() / "none", "--out", small})), 1,
                 {"none", "no such"});
  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small, "--loss", "0dB"})), 2, {"0dB"});
  EXPECT_FALSE(fs::exists(small));
  expect_outcome(run_to_end(reconstructor({"compress", model_, "--out", small})), 0, {"dB lost"});
  expect_outcome(run_to_end(reconstructor({"compress", small, "--out", temp_.path() / "again"})), 2,
                 {"compressed already"});
  write_file(small, "sheenSLF, and no more");
  expect_outcome(run_to_end(reconstructor({"evaluate", small, session_})), 1, {"small.slf", "version"});
  write_file(small, "a text");
  expect_outcome(run_to_end(reconstructor({"view", small})), 1, {"small.slf", "not a model"});
}

TEST_F(Evaluate, AModelThatDoesNotSayWhatItIsMadeOfIsRefused) {
  build("hold_out_every = 4", model_);
  Json description = Json::parse(read_file(model_ / "model.json"));
  description["metadata"].erase("captures");
  write_file(model_ / "model.json", description.dump());
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, session_})), 1, {model_, "build it again"});
}

TEST_F(Evaluate, ImagesThatTheModelWasNotBuiltFromAreNoHeldOutViews) {
  build("hold_out_every = 4", model_);
  const fs::path other = temp_.path() / "other";
  {
    Session session = Session::create(other);
    for (int i = 0; i < 4; ++i) session.append(photograph({0.1, 0.02 * i, 0.45}, 2, i));
  }
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, other})), 1, {other, "none of the images", model_});
}

}  // namespace
}  // namespace sheen::testing
