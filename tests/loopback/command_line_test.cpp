// SPDX-License-Identifier: Apache-2.0
// The commands as a shell has them: where output goes, what is checked before the work, what numbers are taken.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class CommandLineUse : public ::testing::Test {
 protected:
  CommandLineUse() { data_.write(); }

  Words build(const Words& more) const {
    return reconstructor({"build", data_.folder, "--mesh", data_.mesh(), "--config", data_.scene()}) + more;
  }
  Words track(const Words& more) const {
    return tracker(
               {"run", "--source", "dataset:" + data_.folder.string(), "--endpoint", free_address(), "--linger", "0"}) +
           more;
  }
  /// The command with its standard output redirected, as a shell does it.
  static Words to(const fs::path& output, const Words& command) {
    std::string line;
    for (const std::string& word : command) line += "'" + word + "' ";
    return {"sh", "-c", line + "> '" + output.string() + "'"};
  }

  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data", .views = 6};
};

TEST_F(CommandLineUse, JsonOnStandardOutputIsOneDocument) {
  const fs::path out = temp_.path() / "out.json", model = temp_.path() / "model";
  const auto document = [&](const Words& command, int status) {
    expect_outcome(run_to_end(to(out, command)), status, {});
    return nlohmann::json::parse(read_file(out));
  };
  EXPECT_EQ(document(build({"--out", model, "--json", "-"}), 0)["frames"]["accepted"], 5);
  EXPECT_EQ(document(reconstructor({"evaluate", model, data_.folder, "--json", "-"}), 0)["views"].size(), 1u);
  const Json rendered = document(reconstructor({"render", model, "--cameras", data_.folder / "transforms.json", "--out",
                                                temp_.path() / "views", "--json", "-"}),
                                 0);
  ASSERT_EQ(rendered["pictures"].size(), 6u);
  for (const Json& picture : rendered["pictures"]) {
    EXPECT_TRUE(fs::exists((temp_.path() / "views" / picture["file"].get<std::string>()).string() + ".exr"));
    EXPECT_GT(picture["predicted_psnr_db"], 10);
  }
  EXPECT_EQ(document(track({"--json", "-"}), 1)["frames"]["sent"], 6) << "nobody took them";
  EXPECT_TRUE(document(tracker({"stage", "--out", temp_.path() / "s.svg", "--json"}), 0).contains("tags"));
  EXPECT_TRUE(
      document(tracker({"keygen", "--out", temp_.path(), "--name", "desk", "--json"}), 0).contains("public_key"));
}

TEST_F(CommandLineUse, TheNumericsAreTestedOnTheMachineWhereTheyAreUsed) {
  expect_outcome(run_to_end(reconstructor({"doctor", "--numerics"})), 0, {"near-duplicates: orthogonality lost"});
}

TEST_F(CommandLineUse, WhatTheSceneRequiredIsRenderedWhereItIsAskedFor) {
  const fs::path model = temp_.path() / "model.slf", views = temp_.path() / "views", report = temp_.path() / "r.json";
  expect_outcome(run_to_end(build({"--out", model})), 0, {});
  const Words render =
      reconstructor({"render", model, "--cameras", data_.folder / "transforms.json", "--out", views, "--json", report});
  expect_outcome(run_to_end(render + Words{"--demand"}), 0, {"what the scene required"});
  const Json json = Json::parse(read_file(report));
  const std::string first = (views / json["pictures"][0]["file"].get<std::string>()).string();
  for (const char* part : {"rank", "resolution", "bytes"}) {
    EXPECT_GT(json["demand"][part], 0) << part;
    EXPECT_TRUE(fs::exists(first + "." + part + ".png")) << part;
    const ExrFile file = read_exr(first + ".exr");
    ASSERT_TRUE(file.find(part)) << part;
    const ImageF& values = file.find(part)->image;
    EXPECT_GT(*std::max_element(values.data(), values.data() + values.size()), 0) << part;
  }
  expect_outcome(run_to_end(render), 0, {});
  EXPECT_FALSE(read_exr(first + ".exr").find("rank")) << "only where it is asked for";
}

TEST_F(CommandLineUse, LayersOfThePictureAreRenderedWhereTheyAreAskedFor) {
  const fs::path model = temp_.path() / "model.slf", views = temp_.path() / "views", report = temp_.path() / "r.json";
  expect_outcome(run_to_end(build({"--out", model})), 0, {});
  const Words render =
      reconstructor({"render", model, "--cameras", data_.folder / "transforms.json", "--out", views, "--json", report});
  expect_outcome(run_to_end(render + Words{"--layers", "depth,normals"}), 0, {});
  const std::string first =
      (views / Json::parse(read_file(report))["pictures"][0]["file"].get<std::string>()).string() + ".exr";
  const ExrFile file = read_exr(first);
  ASSERT_TRUE(file.find("depth") && file.find("normals"));
  EXPECT_EQ(file.find("depth")->channels, std::vector<std::string>{"Z"});
  EXPECT_EQ(file.find("normals")->channels, (std::vector<std::string>{"X", "Y", "Z"}));
  const ImageF &depth = file.find("depth")->image, &normals = file.find("normals")->image,
               &coverage = file.find("coverage")->image;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    EXPECT_EQ(std::isfinite(depth.data()[i]), coverage.data()[i] > 0) << i;
    EXPECT_NEAR(Eigen::Vector3f::Map(normals.data() + 3 * i).norm(), coverage.data()[i] > 0 ? 1 : 0, 1e-5) << i;
  }
  expect_outcome(run_to_end(render + Words{"--layers", "reflectance"}), 2, {"model.slf has no layer reflectance"});
  expect_outcome(run_to_end(render + Words{"--layers", "depth,colour"}), 2, {"colour"});
}

TEST_F(CommandLineUse, WhereNoPhotographIsFromIsSaidAndGuessesAreMarkedOnDemand) {
  const fs::path model = temp_.path() / "model.slf", views = temp_.path() / "views", report = temp_.path() / "r.json",
                 cameras = temp_.path() / "below.json";
  expect_outcome(run_to_end(build({"--out", model})), 0, {});
  Json json = Json::parse(read_file(data_.folder / "transforms.json"));
  for (const int axis : {1, 2})  // half a turn round x: from below, where nobody was
    for (Json& number : json["frames"][2]["transform_matrix"][axis]) number = -number.get<double>();
  write_file(cameras, json.dump());
  const Words render = reconstructor({"render", model, "--cameras", cameras, "--out", views, "--json", report});
  expect_outcome(run_to_end(render), 0,
                 {"2 of 6 views are more than 15 degrees from every photograph: 1002 is farthest"});
  const Json pictures = Json::parse(read_file(report))["pictures"];
  EXPECT_GT(pictures[4]["nearest_photograph_deg"], 15) << "the one that was held out";
  EXPECT_GT(pictures[2]["nearest_photograph_deg"], 15);
  EXPECT_LT(pictures[0]["nearest_photograph_deg"], 0.1);

  const RawImage plain = read_image(views / "1002.png");
  const std::string exr = read_file(views / "1002.exr");
  expect_outcome(run_to_end(render + Words{"--mark-guesses"}), 0, {});
  EXPECT_EQ(read_file(views / "1002.exr"), exr) << "only pictures for people are marked";
  const RawImage marked = read_image(views / "1002.png");
  ASSERT_EQ(plain.format, PixelFormat::kRGB8);
  const ImageF coverage = read_exr(views / "1002.exr").find("coverage")->image;
  int guesses = 0;
  for (int y = 0; y < coverage.height(); ++y)
    for (int x = 0; x < coverage.width(); ++x) {
      const bool guess = coverage.at(x, y) > 0 && coverage.at(x, y) < 1;
      const std::size_t at = static_cast<std::size_t>(y) * plain.stride + 3 * static_cast<std::size_t>(x);
      const bool same = std::equal(&plain.bytes[at], &plain.bytes[at] + 3, &marked.bytes[at]);
      EXPECT_EQ(same, !guess) << x << " " << y;
      guesses += guess;
    }
  EXPECT_GT(guesses, 100);
}

TEST_F(CommandLineUse, OneWordSetsLimitsAndSize) {
  const fs::path report = temp_.path() / "report.json", small = temp_.path() / "small.slf";
  expect_outcome(run_to_end(build({"--favour", "size", "--out", small, "--json", report})), 0, {});
  Json settings = Json::parse(read_file(report))["settings"];
  EXPECT_EQ(settings["favour"], "size");
  EXPECT_EQ(settings["tolerance"], 0.02);
  EXPECT_FALSE(settings.contains("budget"));
  const auto bytes = fs::file_size(small);
  expect_outcome(run_to_end(build({"--favour", "accuracy", "--out", temp_.path() / "large.slf"})), 0, {});
  EXPECT_LT(bytes, fs::file_size(temp_.path() / "large.slf"));
  expect_outcome(run_to_end(build({"--favour", "speed", "--budget", "9s", "--json", report})), 0, {});
  settings = Json::parse(read_file(report))["settings"];
  EXPECT_EQ(settings["budget"]["asked_ms"], 9000) << "what is given stays";
  EXPECT_EQ(settings["effort_level"], 0);
  expect_outcome(run_to_end(build({"--favour", "luck"})), 2, {"--favour", "luck"});
}

TEST_F(CommandLineUse, AStageFitsItsPaperAndKeepsItsLayout) {
  const fs::path a4 = temp_.path() / "a4.svg", layout = temp_.path() / "a4.json";
  expect_outcome(run_to_end(tracker({"stage", "--out", a4, "--paper", "A4"})), 0, {"a4.json", "25 mm"});
  EXPECT_THAT(read_file(a4), HasSubstr("width=\"297"));
  EXPECT_THAT(read_file(a4), HasSubstr("height=\"210"));
  const std::string before = read_file(layout);
  expect_outcome(run_to_end(tracker({"stage", "--out", a4, "--paper", "A4"})), 0, {});
  expect_outcome(run_to_end(tracker({"stage", "--out", a4, "--paper", "letter"})), 1, {"a4.json", "another layout"});
  EXPECT_EQ(read_file(layout), before);
  expect_outcome(run_to_end(tracker({"stage", "--out", a4, "--paper", "A4", "--size", "400x300"})), 2, {});
}

TEST_F(CommandLineUse, AStageIsSurveyedByACommandOfItsOwn) {
  expect_outcome(run_to_end(tracker({"stage", "survey", "--help"})), 0, {"--length", "--camera"});
  expect_outcome(run_to_end(tracker({"stage"})), 2, {"--out is required"});
}

TEST_F(CommandLineUse, DoctorDoesNotPassTheExamplesNumbers) {
  const fs::path rig = temp_.write("example.toml",
                                   "[camera]\nwidth = 1024\nheight = 768\nfx = 1200.0\nfy = 1200.0\ncx = 511.5\n"
                                   "cy = 383.5\n\n[source]\nuri = \"aravis:CAMERA\"\n");
  expect_outcome(run_to_end(tracker({"doctor", "--config", rig})), 1, {"calibrate", "placeholder"});
}

TEST_F(CommandLineUse, AFullDiskIsAFailure) {
  for (const Words& command : {build({"--json", "-"}), tracker({"stage", "--out", temp_.path() / "s.svg", "--json"}),
                               tracker({"--version"}), reconstructor({"build", "--help"})})
    expect_outcome(run_to_end(to("/dev/full", command)), 1, {"standard output: cannot be written"});
  expect_outcome(run_to_end(build({"--json", "/dev/full"})), 1, {"/dev/full", "cannot be written"});
  EXPECT_FALSE(fs::is_regular_file("/dev/full"));
}

TEST_F(CommandLineUse, WhereResultsGoIsTriedBeforeTheWork) {
  const fs::path nowhere = temp_.path() / "nowhere" / "report.json", file = temp_.write("file", "x");
  for (const Outcome& outcome :
       {run_to_end(build({"--json", nowhere})), run_to_end(track({"--json", nowhere})),
        run_to_end(build({"--json", temp_.path()})), run_to_end(build({"--out", file / "model"}))}) {
    EXPECT_EQ(outcome.end.status, 1) << outcome.output;
    EXPECT_THAT(outcome.output, Not(HasSubstr("images added to the model")));
    EXPECT_THAT(outcome.output, Not(HasSubstr("keyframes sent")));
  }
}

TEST_F(CommandLineUse, AModelThatIsNotKeptIsTold) {
  expect_outcome(run_to_end(build({})), 0, {"no --out", "not kept", "mesh.ply: 320 triangles, 100 x 100 x 100 mm"});
}

TEST_F(CommandLineUse, NumbersThatMakeNoSense) {
  struct Case {
    Words command;
    const char* option;
  };
  const Words run{"run", "--source", "dataset:x"}, stage{"stage", "--out", temp_.path() / "s.svg"};
  for (const Case& c :
       {Case{tracker(run + Words{"--frames", "-1"}), "--frames"},
        Case{tracker(run + Words{"--frames", "1.5"}), "--frames"},
        Case{tracker(run + Words{"--linger", "nan"}), "--linger"},
        Case{tracker(run + Words{"--linger", "-1"}), "--linger"}, Case{tracker(stage + Words{"--tag", "inf"}), "--tag"},
        Case{tracker(stage + Words{"--first-id", "-1"}), "--first-id"},
        Case{tracker({"simulate", "--out", "x", "--frames", "0"}), "--frames"},
        Case{tracker({"simulate", "--serve", "x", "--rate", "nan"}), "--rate"},
        Case{tracker({"simulate", "--serve", "x", "--out", "y"}), "the same folder"},
        Case{build({"--hold-out", "-1"}), "--hold-out"},
        Case{reconstructor({"undo", "x", "--capture", "-1"}), "--capture"},
        Case{reconstructor({"view", "x", "--eye", "0,nan,0"}), "--eye"}})
    expect_outcome(run_to_end(c.command), 2, {c.option});
}

TEST_F(CommandLineUse, VersionsAndMisspeltCommands) {
  expect_outcome(run_to_end(tracker({"--version"})), 0, {"."});
  expect_outcome(run_to_end(reconstructor({"--version"})), 0, {"."});
  expect_outcome(run_to_end(reconstructor({"biuld"})), 2, {"biuld", "did you mean \"build\"?", "--help"});
  expect_outcome(run_to_end(tracker({"simulat"})), 2, {"did you mean \"simulate\"?"});
}

TEST_F(CommandLineUse, AMeshInMillimetres) {
  Mesh mesh = load_mesh(data_.mesh()).mesh;
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= 1000;
  save_ply(mesh, data_.mesh());
  expect_outcome(run_to_end(build({})), 1,
                 {"mesh.ply", "100 x 100 x 100 m", "looks like millimetres", "scale the mesh by 0.001"});
}

TEST_F(CommandLineUse, CtrlCEndsTheWorkOnALargeMesh) {
  save_ply(sphere_mesh(0.05f, 7), data_.mesh());  // 327,680 triangles: seconds before the first image is in
  Process work(build({"--out", temp_.path() / "model"}));
  ASSERT_TRUE(work.prints("327680 triangles", kPatience)) << work.output();
  work.signal(SIGINT);
  const auto end = work.wait(std::chrono::seconds(10));
  ASSERT_TRUE(end) << "still at work";
  EXPECT_EQ(end->status, 1);
  EXPECT_THAT(work.output(), HasSubstr("stopped"));
  EXPECT_FALSE(fs::exists(temp_.path() / "model" / "model.json"));
}

TEST_F(CommandLineUse, AllViewsHeldOut) {
  const fs::path file = data_.folder / "transforms.json";
  auto json = nlohmann::json::parse(read_file(file));
  json["test_filenames"] = nlohmann::json::array();
  for (const auto& frame : json["frames"]) json["test_filenames"].push_back(frame["file_path"]);
  json.erase("train_filenames");
  write_file(file, json.dump());
  expect_outcome(run_to_end(build({})), 1, {"all of its images", "held out", "test_filenames"});
}

TEST_F(CommandLineUse, RenderedFramesOfEqualNamesKeepTheirFolders) {
  const fs::path model = temp_.path() / "model", out = temp_.path() / "views", cameras = temp_.path() / "cameras.json";
  ASSERT_EQ(run_to_end(build({"--out", model})).end.status, 0);
  auto json = nlohmann::json::parse(read_file(data_.folder / "transforms.json"));
  json["frames"].erase(json["frames"].begin() + 2, json["frames"].end());
  json["frames"][0]["file_path"] = "left/0000.png";
  json["frames"][1]["file_path"] = "right/0000.png";  // the lists still name frames that are not here
  write_file(cameras, json.dump());
  expect_outcome(run_to_end(reconstructor({"render", model, "--cameras", cameras, "--out", out})), 0, {"2 views"});
  EXPECT_NE(read_file(out / "left/0000.png"), read_file(out / "right/0000.png"));
  EXPECT_TRUE(fs::exists(out / "left/0000.exr") && fs::exists(out / "right/0000.exr"));
}

}  // namespace
}  // namespace sheen::testing
