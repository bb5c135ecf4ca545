// SPDX-License-Identifier: Apache-2.0
// Nobody gives a mesh: `shape`, `build` and `serve` find it in the images of a ball, which end where the ball's closed
// form says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/files.h"
#include "common/base/order_statistics.h"
#include "common/geometry/mesh.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr float kRadius_m = 0.05f, kPixel_m = 0.001f;

class ShapeOfABall : public ::testing::Test {
 protected:
  ShapeOfABall() { ball_.write(); }

  /// Closed, and its upper side, which the images show, where the ball is.
  static void expect_ball(const fs::path& file) {
    const LoadedMesh loaded = load_mesh(file);
    EXPECT_EQ(loaded.diagnosis.boundary_edges, 0u);
    EXPECT_EQ(loaded.diagnosis.non_manifold_edges, 0u);
    EXPECT_EQ(loaded.diagnosis.components, 1u);
    std::vector<float> off;
    for (const Eigen::Vector3f& v : loaded.mesh.vertices)
      if (v.z() > 0.3f * kRadius_m) off.push_back(std::abs(v.norm() - kRadius_m));
    ASSERT_GT(off.size(), 100u);
    EXPECT_LT(quantile(off, 0.5), kPixel_m);
    EXPECT_LT(quantile(off, 0.9), 2 * kPixel_m);
  }
  Words serve(const Words& more) const {
    return reconstructor({"serve", "--session", session_, "--config", ball_.scene(), "--headless", "--no-monitor",
                          "--endpoint", address_}) +
           more;
  }
  Words track() const { return patient_run({"--source", "dataset:" + ball_.folder.string(), "--endpoint", address_}); }

  const TempFolder temp_;
  const BallDataset ball_{.folder = temp_.path() / "ball", .views = 40};
  const fs::path session_ = temp_.path() / "session", report_ = temp_.path() / "report.json",
                 mesh_ = temp_.path() / "found.ply";
  const std::string address_ = "tcp://127.0.0.1:" + std::to_string(free_port());
};

TEST_F(ShapeOfABall, OfADataSetIsWritten) {
  expect_outcome(
      run_to_end(reconstructor({"shape", ball_.folder, "--out", mesh_, "--triangles", "2000", "--json", report_})), 0,
      {"shape: ", "of its vertices"});
  expect_ball(mesh_);
  const Json report = Json::parse(read_file(report_));
  EXPECT_LE(report["triangles"], 2000);
  EXPECT_EQ(report["images"], 35) << "held-out views are not looked at";
  EXPECT_GT(report["evidence"]["seen"], 0.5);
  EXPECT_GT(report["evidence"]["outline"].get<double>() + report["evidence"]["guessed"].get<double>(), 0.02)
      << "nobody saw the underside";
}

TEST_F(ShapeOfABall, BuildNeedsNoMesh) {
  expect_outcome(run_to_end(reconstructor({"build", ball_.folder, "--config", ball_.scene(), "--out",
                                           temp_.path() / "model", "--json", report_})),
                 0, {"no --mesh: the shape is found in the images", "35 images added"});
  const Json report = Json::parse(read_file(report_));
  EXPECT_GT(report["shape"]["evidence"]["seen"], 0.5);
  EXPECT_GT(report["held_out"]["psnr_db"].get<double>(), report["held_out"]["constant_psnr_db"].get<double>() + 3);
}

TEST_F(ShapeOfABall, OfTooFewImagesIsRefused) {
  const BallDataset few{.folder = temp_.path() / "few", .views = 2};
  few.write();
  expect_outcome(run_to_end(reconstructor({"shape", few.folder, "--out", mesh_})), 1,
                 {"only 2 of the images", "3 or more"});
  EXPECT_FALSE(fs::exists(mesh_));
  expect_outcome(run_to_end(reconstructor({"build", few.folder})), 1,
                 {"no shape is found in the images", "Or give --mesh"});
}

TEST_F(ShapeOfABall, GrowsWhileImagesCome) {
  Process desk(serve({"--once", "--json", report_}));
  expect_outcome(run_to_end(track()), 0, {"40 keyframes sent"});
  expect_outcome(wait_to_end(desk), 0, {"found in the images so far", "the model is saved", "35 images added"});
  expect_ball(session_ / "shape.ply");
  const Json report = Json::parse(read_file(report_));
  ASSERT_FALSE(report["shape"].empty());
  EXPECT_EQ(report["shape"].back()["images"], 35) << "the last look is at all of them";
  EXPECT_GT(report["held_out"]["psnr_db"].get<double>(), report["held_out"]["constant_psnr_db"].get<double>() + 3);
  expect_outcome(run_to_end(reconstructor({"build", session_, "--config", ball_.scene()})), 0,
                 {"the shape is shape.ply of the session", "35 images added"});
}

TEST_F(ShapeOfABall, IsThereAgainAfterAKill) {
  Process desk(serve({}));
  expect_outcome(run_to_end(track()), 0, {"40 keyframes sent"});
  ASSERT_TRUE(desk.prints("found in the images so far", kPatience)) << desk.output();
  desk.kill();
  Process again(serve({}));
  ASSERT_TRUE(again.prints("as the session has it", kPatience)) << again.output();
  ASSERT_TRUE(again.prints("what the camera makes of light", kPatience)) << again.output();
  again.signal(SIGINT);
  expect_outcome(wait_to_end(again), 0, {"35 images added", "5 held out"});
}

TEST_F(ShapeOfABall, EndsBeforeThereIsOne) {
  Process desk(serve({}));
  ASSERT_TRUE(desk.prints("waiting for a tracker", kPatience)) << desk.output();
  desk.signal(SIGINT);
  expect_outcome(wait_to_end(desk), 0, {"ended before"});
}

}  // namespace
}  // namespace sheen::testing
