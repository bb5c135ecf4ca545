// SPDX-License-Identifier: Apache-2.0
// A lamp that carries a tag, and one on a gantry, before a camera that is moved by hand: a video goes through the
// tracker into a session, each image with the light that it was taken in.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/videoio.hpp>

#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "common/session/session.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"
#include "tests/tracker/synthetic_stage.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kLampTag = 300, kFrames = 6, kUnseen = 4;
constexpr double kTagSize_m = 0.04, kArm_m = 0.3;

class TaggedLamp : public ::testing::Test {
 protected:
  TaggedLamp() {
    const StageLayout stage = make_stage({});
    save_stage(stage, temp_.path() / "stage.json");
    // Without loss: what is compared with the truth is the tracker, not a codec.
    cv::VideoWriter video((temp_.path() / "hand.avi").string(), cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 1,
                          {camera_.width, camera_.height});
    for (int i = 0; i < kFrames; ++i) {
      const double a = i * M_PI / 3, tilt = 0.5 + 0.05 * i;
      const Rigid3 pose =
          look_at(0.62 * Eigen::Vector3d(std::sin(tilt) * std::cos(a), std::sin(tilt) * std::sin(a), std::cos(tilt)),
                  {0, 0, 0}, {0.1, 0.2, 1});
      StageLayout seen = stage;
      const double h = kTagSize_m / 2;
      const Eigen::Vector3d centre = place(i);
      if (i != kUnseen)
        seen.tags.push_back(
            {.id = kLampTag,
             .corners_object = {centre + Eigen::Vector3d(-h, h, 0), centre + Eigen::Vector3d(h, h, 0),
                                centre + Eigen::Vector3d(h, -h, 0), centre + Eigen::Vector3d(-h, -h, 0)}});
      const ImageU8 grey = render_stage(camera_, seen, pose, 4);
      cv::Mat bgr(camera_.height, camera_.width, CV_8UC3);
      for (int y = 0; y < grey.height(); ++y)
        for (int x = 0; x < grey.width(); ++x) bgr.at<cv::Vec3b>(y, x) = cv::Vec3b::all(grey.at(x, y));
      video.write(bgr);
    }
    const float r = 0.03f;
    save_ply({.vertices = {{r, 0, 0}, {-r, r, 0}, {-r, -r, 0}, {0, 0, r}},
              .triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}}},
             temp_.path() / "mesh.ply");
  }
  /// Of the lamp's tag.
  static Eigen::Vector3d place(int frame) { return {0.02 * (frame % 3 - 1), 0.03 * (frame % 2) - 0.015, 0}; }

  fs::path rig(const std::string& light) const {
    return temp_.write("rig.toml",
                       "[camera]\nwidth = 1024\nheight = 768\nfx = 1200\nfy = 1198\ncx = 515.3\ncy = 380.2\n"
                       "[stage]\nfile = \"stage.json\"\n[gate]\nmax_blur_px = 1000\n[light]\n" +
                           light);
  }
  /// What `run` says, and the session that `serve` makes of it.
  Outcome track(const fs::path& config) const {
    const std::string address = free_address();
    Process desk(reconstructor({"serve", "--session", session_, "--mesh", temp_.path() / "mesh.ply", "--headless",
                                "--no-monitor", "--endpoint", address}));
    const Outcome outcome =
        run_to_end(patient_run({"--config", config, "--source", "video:" + (temp_.path() / "hand.avi").string(),
                                "--endpoint", address, "--json", temp_.path() / "run.json"}));
    desk.kill();  // only what was recorded is looked at
    return outcome;
  }
  nlohmann::json refused() const {
    return nlohmann::json::parse(read_file(temp_.path() / "run.json"))["frames"]["refused"];
  }

  const TempFolder temp_;
  const Camera camera_ = stage_camera(true);
  const fs::path session_ = temp_.path() / "session";
};

TEST_F(TaggedLamp, IsWhereItsTagSaysAndAFrameWithoutItIsRefused) {
  expect_outcome(track(rig("tag = 300\ntag_size_m = 0.04\noffset = [0, 0, 0.3]\n")), 0,
                 {"5 keyframes sent", "1 lamp_tag_not_seen"});
  EXPECT_EQ(refused(), (nlohmann::json{{"lamp_tag_not_seen", 1}}));
  const Session session = Session::open_read_only(session_);
  ASSERT_EQ(session.size(), 5u);
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const Capture capture = session.read(i);
    EXPECT_EQ(capture.light.kind, LightKind::kPoint);
    const Eigen::Vector3d truth = place(static_cast<int>(capture.camera_frame_id)) + Eigen::Vector3d(0, 0, kArm_m);
    EXPECT_LT((capture.light.position - truth).norm(), 0.001) << capture.light.position.transpose();
    RecordProperty("lamp_error_mm_" + std::to_string(i), std::to_string(1e3 * (capture.light.position - truth).norm()));
  }
}

TEST_F(TaggedLamp, OfAGantryEndsWithItsTable) {
  temp_.write("lamps.lp", "4\na 0 0 0.8\nb 0.1 0 0.8\nc 0.2 0 1.1\nd 0.3 0 1.2\n");
  expect_outcome(track(rig("table = \"lamps.lp\"\nfirst_frame = 0\n")), 0,
                 {"4 keyframes sent", "2 beyond_light_table"});
  const Session session = Session::open_read_only(session_);
  ASSERT_EQ(session.size(), 4u);
  EXPECT_EQ(session.read(0).light.position, Eigen::Vector3d(0, 0, 0.8));
  EXPECT_EQ(session.read(3).light.position, Eigen::Vector3d(0.3, 0, 1.2));
}

TEST_F(TaggedLamp, WrongRigsAreNamed) {
  const auto fails = [&](const std::string& light, int status, const Words& says) {
    expect_outcome(
        run_to_end(tracker({"run", "--config", rig(light), "--source", "video:" + (temp_.path() / "hand.avi").string(),
                            "--linger", "0", "--endpoint", free_address()})),
        status, says);
  };
  fails("tag = 0\ntag_size_m = 0.04\n", 2, {"light.tag: 0 is a tag of the stage"});
  fails("table = \"none.lp\"\nfirst_frame = 0\n", 1, {"none.lp"});
  fails("table = \"lamps.lp\"\n", 2, {"rig.toml", "light.table needs index"});
}

}  // namespace
}  // namespace sheen::testing
