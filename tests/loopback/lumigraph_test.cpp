// SPDX-License-Identifier: Apache-2.0
// An intrinsic lumigraph, as a user has it: a data set with light keys is rendered, built, scored, relit and drawn.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Lumigraph : public ::testing::Test {
 protected:
  Lumigraph() {
    expect_outcome(
        run_to_end(tracker({"simulate", "--out", rig_, "--lights", "5", "--views", "2x1", "--size", "160x120"})), 0,
        {"5 lights"});
  }
  Outcome build(const Words& more) const {
    return run_to_end(reconstructor({"build", rig_, "--model", "intrinsic-lumigraph", "--mesh", rig_ / "mesh.ply"}) +
                      more);
  }

  const TempFolder temp_;
  const fs::path rig_ = temp_.path() / "rig", model_ = temp_.path() / "model", out_ = temp_.path() / "out";
};

TEST_F(Lumigraph, IsBuiltScoredAndRelit) {
  const fs::path report = temp_.path() / "build.json", scores = temp_.path() / "scores.json";
  expect_outcome(build({"--out", model_, "--json", report}), 0, {"10 images added to the model"});
  const Json built = Json::parse(read_file(report));
  EXPECT_GT(built["held_out"]["psnr_db"], 40);
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, rig_, "--baselines", "--json", scores})), 0,
                 {"linear interpolation of images"});
  const Json scored = Json::parse(read_file(scores));
  EXPECT_EQ(scored["object"]["psnr_db"], built["held_out"]["psnr_db"]);

  const fs::path list = temp_.write("test.lp", "2\nnear.png 0.5 -0.6 1\nfar.png -0.5 0.6 1.4\n");
  expect_outcome(run_to_end(reconstructor({"render", model_, "--lights", list, "--out", out_})), 0,
                 {"2 pictures rendered"});
  EXPECT_TRUE(fs::exists(out_ / "near.png"));
  EXPECT_TRUE(fs::exists(out_ / "far.exr"));
  expect_outcome(run_to_end(reconstructor({"render", model_, "--cameras", rig_ / "transforms.json", "--out", out_})), 0,
                 {"views rendered"});
}

TEST_F(Lumigraph, NeedsNoMesh) {
  const fs::path report = temp_.path() / "build.json";
  expect_outcome(
      run_to_end(reconstructor({"build", rig_, "--model", "intrinsic-lumigraph", "--out", model_, "--json", report})),
      0, {"10 images added to the model"});
  const Json built = Json::parse(read_file(report));
  EXPECT_GT(built["held_out"]["psnr_db"], built["held_out"]["constant_psnr_db"]);
  const fs::path list = temp_.write("test.lp", "1\nnear.png 0.5 -0.6 1\n");
  expect_outcome(run_to_end(reconstructor({"render", model_, "--lights", list, "--out", out_})), 0,
                 {"1 pictures rendered"});
}

/// What it sees lies in a flat box of kilometres, which is not to be filled with cells as fine as the others' pixels.
TEST_F(Lumigraph, OneCameraFarOffTakesNoMoreMemory) {
  Json json = Json::parse(read_file(rig_ / "transforms.json"));
  const Json nearby = json["frames"][0]["transform_matrix"];
  for (Json& frame : json["frames"])
    if (frame["transform_matrix"] == nearby) frame["transform_matrix"][2][3] = nearby[2][3].get<double>() + 65'000;
  write_file(rig_ / "transforms.json", json.dump());
  expect_outcome(run_to_end(reconstructor({"build", rig_, "--model", "intrinsic-lumigraph", "--out", model_})), 0,
                 {"images added to the model"});
  const fs::path list = temp_.write("test.lp", "1\nnear.png 0.5 -0.6 1\n");
  expect_outcome(run_to_end(reconstructor({"render", model_, "--lights", list, "--out", out_})), 0,
                 {"1 pictures rendered"});
}

TEST_F(Lumigraph, WithoutAMeshTheObjectIsLookedForAtTheOrigin) {
  Json json = Json::parse(read_file(rig_ / "transforms.json"));
  for (Json& frame : json["frames"])
    frame["transform_matrix"][1][3] = frame["transform_matrix"][1][3].get<double>() + 4'649'776.5;
  write_file(rig_ / "transforms.json", json.dump());
  expect_outcome(run_to_end(reconstructor({"build", rig_, "--model", "intrinsic-lumigraph", "--out", model_})), 2,
                 {"without --mesh", "4650 km from the cameras"});
}

TEST_F(Lumigraph, WantsItsLights) {
  Json json = Json::parse(read_file(rig_ / "transforms.json"));
  for (Json& frame : json["frames"]) frame.erase("light_position");
  write_file(rig_ / "transforms.json", json.dump());
  expect_outcome(build({}), 1, {"no_light_position"});
  json["frames"][0]["light_position"] = {0, "x", 1};
  write_file(rig_ / "transforms.json", json.dump());
  expect_outcome(build({}), 1, {"frame 0", "light_position", "must be 3 numbers"});
}

TEST_F(Lumigraph, IsDrawn) {
  expect_outcome(build({"--out", model_}), 0, {});
  const fs::path picture = temp_.path() / "window.png";
  const Outcome outcome = run_to_end(Words{SHEEN_WITH_XVFB} +
                                     reconstructor({"view", model_, "--screenshot", picture, "--size", "160x120"}));
  if (outcome.output.find("without a display") != std::string::npos) GTEST_SKIP() << "no Xvfb here";
  expect_outcome(outcome, 0, {});
  EXPECT_TRUE(fs::exists(picture));
}

}  // namespace
}  // namespace sheen::testing
