// SPDX-License-Identifier: Apache-2.0
// `refine`, `build` that refines by itself and with `--refine`, and `serve --refine`, judged on views that neither saw.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/datasets/dataset.h"
#include "common/geometry/mesh.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
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

TEST_F(Refine, PosesOfASessionAreNotWritten) {
  expect_outcome(run_to_end(reconstructor({"refine", session_, "--mesh", right_, "--out", out_, "--poses",
                                           temp_.path() / "transforms.json"})),
                 1, {"is a session", "stage survey"});
  EXPECT_FALSE(fs::exists(out_));
}

/// The same photographs on disk, as a data set. `poses_off`: each is turned by up to some pixels at the square's
/// border.
class RefineDataset : public Refine {
 protected:
  explicit RefineDataset(bool poses_off = false) {
    fs::create_directories(temp_.path() / "set" / "images");
    const Session session = Session::open_read_only(session_);
    std::vector<DatasetView> views;
    for (std::uint64_t i = 0; i < session.size(); ++i) {
      const Capture capture = session.read(i);
      const std::string name = "images/" + std::to_string(i) + ".png";
      write_png(temp_.path() / "set" / name, to_srgb8(to_linear_rgb(capture.image)));
      const double angle = poses_off * 0.015 * std::sin(1 + 7.0 * static_cast<double>(i));
      const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                        Eigen::Vector3d::Zero()};
      right_poses_.push_back(capture.pose.camera_from_object);
      views.push_back({.name = name,
                       .image_path = {},
                       .mask_path = {},
                       .camera = capture.camera,
                       .camera_from_object = right_poses_.back() * turn,
                       .purpose = i % 5 == 0 ? Purpose::kHeldOut : Purpose::kTraining});
    }
    write_transforms(set_ / "transforms.json", views);
  }

  /// The report of a build, which must end with `status` and say all of `words`.
  Json built(const fs::path& mesh, const Words& more, int status, const Words& words) const {
    expect_outcome(
        run_to_end(reconstructor({"build", set_, "--mesh", mesh, "--out", model_, "--loss", "0dB", "--json", report_}) +
                   more),
        status, words);
    return fs::exists(report_) ? Json::parse(read_file(report_)) : Json();
  }

  /// Mean angle to the right poses.
  double off(const Dataset& dataset) const {
    double sum = 0;
    for (std::size_t i = 0; i < right_poses_.size(); ++i)
      sum += dataset.views[i].camera_from_object.rotation.angularDistance(right_poses_[i].rotation);
    return sum / static_cast<double>(right_poses_.size());
  }

  const fs::path set_ = temp_.path() / "set", written_ = temp_.path() / "elsewhere" / "transforms.json",
                 report_ = temp_.path() / "report.json", model_ = temp_.path() / "of_photographs";
  std::vector<Rigid3> right_poses_;
};

TEST_F(RefineDataset, AMeshThatIsOffIsRefinedByItselfAndJudgedOnItsOwnPixels) {
  const Json kept = built(low_, {"--no-refine"}, 0, {});
  EXPECT_FALSE(kept.contains("refinement"));
  const Json refined = built(low_, {}, 0, {"pixels (RMS) from where the mesh has it", "--no-refine keeps it"});
  EXPECT_GT(refined["disagreement"]["off_px"], 2);
  EXPECT_FALSE(refined["refinement"]["left_out"]["kept_given"]);
  EXPECT_GT(refined["held_out"]["psnr_db"].get<double>(), kept["held_out"]["psnr_db"].get<double>() + 2);
  const fs::path scores = temp_.path() / "scores.json";
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, set_, "--object", low_, "--json", scores})), 0, {});
  EXPECT_NEAR(Json::parse(read_file(scores))["object"]["psnr_db"].get<double>(),
              refined["held_out"]["psnr_db"].get<double>(), 0.01);
}

TEST_F(RefineDataset, AMeshThatIsRightStaysToTheBit) {
  EXPECT_FALSE(built(right_, {}, 0, {}).contains("refinement"));
  fs::rename(model_, temp_.path() / "by_itself");
  built(right_, {"--no-refine"}, 0, {});
  expect_same_model(temp_.path() / "by_itself", model_);
}

TEST_F(RefineDataset, ASessionIsToldOfAndNotRefinedByItself) {
  const fs::path of_session = temp_.path() / "of_session";
  expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", low_, "--out", of_session, "--loss", "0dB"})),
                 0, {"--refine corrects it", "a session"});
  EXPECT_EQ(load_mesh(of_session / "mesh.ply").mesh.vertices, load_mesh(low_).mesh.vertices);
}

TEST_F(RefineDataset, PosesOfOtherImagesFailAndAnOlderModelStays) {
  built(right_, {}, 0, {});
  const auto before = fs::last_write_time(model_ / "model.json");
  std::vector<DatasetView> views = load_dataset(set_).views;
  for (std::size_t i = 0; i < views.size(); ++i) views[i].camera_from_object = right_poses_[(7 * i + 3) % views.size()];
  write_transforms(set_ / "transforms.json", views);
  const Json report = built(right_, {}, 1, {"worse", "than one colour", "no model was written"});
  EXPECT_TRUE(report.contains("failed"));
  EXPECT_LT(report["held_out"]["psnr_db"], report["held_out"]["constant_psnr_db"]);
  EXPECT_EQ(fs::last_write_time(model_ / "model.json"), before);
}

TEST_F(RefineDataset, NeitherOfTwoContradictingOptions) {
  built(right_, {"--refine", "--no-refine"}, 2, {"--no-refine"});
  built(right_, {"--refine", "everything"}, 2, {"--refine: must be mesh or poses"});
}

class RefinePoses : public RefineDataset {
 protected:
  RefinePoses() : RefineDataset(true) {}
};

TEST_F(RefinePoses, BuildRefinesThemTooAndOtherwiseSaysWhatTheyWouldGain) {
  const Json kept = built(low_, {}, 0, {"the poses are off as well", "--refine poses"});
  const Json refined = built(low_, {"--refine", "poses"}, 0, {"poses of 40 of 40 images determined"});
  EXPECT_GT(refined["held_out"]["psnr_db"].get<double>(), kept["held_out"]["psnr_db"].get<double>() + 1);
  const fs::path scores = temp_.path() / "scores.json";
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, set_, "--object", low_, "--json", scores})), 0, {});
  EXPECT_NEAR(Json::parse(read_file(scores))["object"]["psnr_db"].get<double>(),
              refined["held_out"]["psnr_db"].get<double>(), 0.01)
      << "the model notes the poses";
  expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", low_, "--refine", "poses"})), 1,
                 {"is a session", "stage survey"});
}

TEST_F(RefinePoses, PosesThatAreOffComeBackAndTheFileNamesTheSameImages) {
  fs::create_directories(written_.parent_path());
  expect_outcome(run_to_end(reconstructor(
                     {"refine", set_, "--mesh", right_, "--out", out_, "--poses", written_, "--json", report_})),
                 0, {"poses of 40 of 40 images determined"});
  const Dataset given = load_dataset(set_), refined = load_dataset(written_.parent_path());
  ASSERT_EQ(refined.views.size(), given.views.size());
  EXPECT_LT(off(refined), 0.3 * off(given));
  for (std::size_t i = 0; i < given.views.size(); ++i) {
    EXPECT_TRUE(fs::equivalent(refined.views[i].image_path, given.views[i].image_path));
    EXPECT_EQ(refined.views[i].purpose, given.views[i].purpose);
  }
  const Json poses = Json::parse(read_file(report_))["poses"];
  EXPECT_FALSE(poses[0]["left_out"]["kept_given"]);
  EXPECT_GT(poses[0]["left_out"]["gain_db"], 1);
  EXPECT_TRUE(poses.back()["left_out"]["kept_given"]) << "it went on until no poses gained";
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
