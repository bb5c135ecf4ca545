// SPDX-License-Identifier: Apache-2.0
// `refine`, `build --refine` and `serve --refine`, judged on views that neither saw.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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

/// Photographs of a square in the plane z = 0; a pixel is 1.25 mm wide on it.
class Refine : public ::testing::Test {
 protected:
  Refine() {
    const Camera camera{.width = 240, .height = 180, .fx = 400, .fy = 400, .cx = 119.5, .cy = 89.5};
    const analytic::Scene scene{analytic::square(0.1, 0), analytic::diffuse(0.03), {0, 0, 0}};
    Session session = Session::create(session_);
    std::uint64_t sequence = 0;
    for (const Eigen::Vector3d& eye : analytic::eyes(40, 0.5, 0.5)) {
      Capture capture = analytic::capture(scene, camera, analytic::towards_origin(eye));
      capture.sequence = ++sequence;
      capture.name = "frame " + std::to_string(sequence);
      session.append(capture);
    }
    save_ply(square_mesh(0.1f, 0, 16), right_);
    save_ply(square_mesh(0.1f, -0.004f, 16), low_);
  }

  /// Of held-out views, on the pixels of the mesh that lies too low.
  double held_out_db(const Words& build_options) const {
    const fs::path model = temp_.path() / "model", report = temp_.path() / "scores.json";
    expect_outcome(run_to_end(reconstructor({"build", session_, "--hold-out", "5", "--out", model, "--loss", "0dB"}) +
                              build_options),
                   0, {});
    expect_outcome(run_to_end(reconstructor({"evaluate", model, session_, "--object", low_, "--json", report})), 0, {});
    return Json::parse(read_file(report))["object"]["psnr_db"];
  }

  const TempFolder temp_;
  const fs::path session_ = temp_.path() / "session", right_ = temp_.path() / "right.ply",
                 low_ = temp_.path() / "low.ply", out_ = temp_.path() / "refined.ply";
};

TEST_F(Refine, AMeshThatIsOffGainsOnHeldOutViews) {
  const fs::path report = temp_.path() / "built.json";
  const double given = held_out_db({"--mesh", low_});
  const double refined = held_out_db({"--mesh", low_, "--refine", "--json", report});
  EXPECT_GT(refined, given + 2);
  const Json refinement = Json::parse(read_file(report))["refinement"];
  EXPECT_FALSE(refinement["left_out"]["kept_given"]);
  EXPECT_GT(refinement["left_out"]["gain_db"], 1);
  EXPECT_EQ(refinement["images"], 32);
}

TEST_F(Refine, AMeshThatIsRightIsWrittenAsItWasGiven) {
  expect_outcome(run_to_end(reconstructor({"refine", session_, "--mesh", right_, "--out", out_})), 0,
                 {"written as given"});
  const Mesh given = load_mesh(right_).mesh, refined = load_mesh(out_).mesh;
  EXPECT_EQ(given.vertices, refined.vertices);
  EXPECT_EQ(given.triangles, refined.triangles);
}

/// Captures come from the session alone: each start takes them in again.
class RefineLive : public Refine {
 protected:
  Json serve_until_interrupted() {
    Process desk(serve(low_, session_, {"--refine", "--endpoint", free_address(), "--json", report_}));
    EXPECT_TRUE(desk.prints("refined against", kPatience));
    desk.signal(SIGINT);
    expect_outcome(wait_to_end(desk), 0, {"the model is saved"});
    return Json::parse(read_file(report_))["refinement"];
  }
  /// The model that `serve` saved is the one of the mesh that it went over to.
  void expect_model_of(const fs::path& mesh) const {
    const fs::path built = temp_.path() / "built";
    expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", mesh, "--out", built, "--loss", "0dB"})), 0,
                   {});
    expect_same_model(session_ / "model", built);
  }
  const fs::path report_ = temp_.path() / "live.json";
};

TEST_F(RefineLive, TheModelGoesOverToTheRefinedMeshAndAStartAfterwardsBeginsThere) {
  const Json looks = serve_until_interrupted();
  ASSERT_EQ(looks.size(), 1u);
  EXPECT_EQ(looks[0]["mesh"], "refined");
  EXPECT_GT(looks[0]["gain_db"], 1);
  const Mesh given = load_mesh(low_).mesh, refined = load_mesh(session_ / "refined.ply").mesh;
  EXPECT_EQ(given.triangles, refined.triangles);
  EXPECT_NE(given.vertices, refined.vertices);
  expect_model_of(session_ / "refined.ply");

  const Json again = serve_until_interrupted();
  EXPECT_EQ(again[0]["mesh"], "as before");
  expect_model_of(session_ / "refined.ply");
}

TEST_F(RefineLive, ARefinedMeshOfAnotherOneIsRefused) {
  save_ply(square_mesh(0.1f, 0, 3), session_ / "refined.ply");
  expect_outcome(run_to_end(serve(low_, session_, {"--refine", "--endpoint", free_address()})), 1,
                 {"refined.ply", "other triangles"});
}

TEST_F(RefineLive, EndsAtOnceWhenItIsAskedTwice) {
  Process desk(serve(low_, session_, {"--refine", "--endpoint", free_address()}));
  ASSERT_TRUE(desk.prints("waiting for a tracker", kPatience));
  desk.signal(SIGINT);
  ASSERT_TRUE(desk.prints("finishing", kPatience));
  desk.signal(SIGINT);
  expect_outcome(wait_to_end(desk), 1, {"ended before the model was finished; nothing is lost"});
}

TEST_F(RefineLive, AMeshThatIsRightStays) {
  fs::copy_file(right_, low_, fs::copy_options::overwrite_existing);
  EXPECT_EQ(serve_until_interrupted()[0]["mesh"], "as before");
  EXPECT_FALSE(fs::exists(session_ / "refined.ply"));
  expect_model_of(low_);
}

TEST_F(Refine, WhatHasNoMeshCannotBeRefined) {
  expect_outcome(run_to_end(reconstructor({"build", session_, "--model", "irradiance-field", "--refine"})), 2,
                 {"--refine"});
  expect_outcome(run_to_end(reconstructor({"serve", "--session", temp_.path() / "new", "--headless", "--model",
                                           "irradiance-field", "--refine"})),
                 2, {"--refine"});
}

}  // namespace
}  // namespace sheen::testing
