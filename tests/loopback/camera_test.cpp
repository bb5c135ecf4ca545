// SPDX-License-Identifier: Apache-2.0
// A camera on the wire: the simulated rig behind a real GigE Vision endpoint, the tracker and the reconstructor, all
// processes of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "common/base/files.h"
#include "common/datasets/light_list.h"
#include "common/image/image_io.h"
#include "common/link/monitor_socket.h"
#include "common/session/session.h"
#include "common/simulation/simulated_rig.h"
#include "tests/loopback/daemons.h"
#include "tests/loopback/sphere_rig.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kFrames = 36;                       ///< three seconds
constexpr std::chrono::seconds kCameraFreed{12};  ///< a camera lets a dead tracker go after about 3 s

/// A fifth of what `attack --kills N` asks for, as an even number; none where ctest asks.
int wanted_kills() {
  const char* wanted = std::getenv("SHEEN_ATTACK_KILLS");
  return wanted ? std::max(std::atoi(wanted) / 10 * 2, 2) : 0;
}

class CameraOnTheWire : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TempFolder>();
    recording_ =
        std::make_unique<RigRecording>(cached_recording(sphere_rig(kFrames), folder_->path() / "rig").recording);
    // So few views round the object are far apart: what would be a fast motion for a hand.
    std::ofstream(config(), std::ios::app) << "\n[gate]\nmax_blur_px = 1000.0\nmax_uncertainty_px = 0.5\n";
  }
  static void TearDownTestSuite() {
    recording_.reset();
    folder_.reset();
  }

  static std::filesystem::path config() { return recording_->folder / "rig.toml"; }
  Words serve_camera() const {
    return tracker({"simulate", "--serve", recording_->folder, "--log", temp_.path() / "sent.csv"});
  }
  Words track(const Words& more) const {
    return patient_run({"--config", config(), "--json", temp_.path() / "tracker.json"}) + link_.tracker_options() +
           more;
  }
  Words desk(const Words& more = {}) const {
    return serve(recording_->mesh_file(), session_,
                 link_.reconstructor_options() + Words{"--json", temp_.path() / "desk.json"} + more);
  }
  /// Which frame of the recording each frame of the camera was.
  std::map<std::uint64_t, std::size_t> sent_frames() const {
    std::map<std::uint64_t, std::size_t> sent;
    std::ifstream log(temp_.path() / "sent.csv");
    char comma = 0;
    std::size_t index = 0;
    for (std::uint64_t id = 0; log >> id >> comma >> index;) sent[id] = index;
    return sent;
  }
  /// As a supervisor would: again and again until the camera lets it in.
  std::unique_ptr<Process> track_again(const Words& more) const {
    std::unique_ptr<Process> rig;
    for (const auto end = std::chrono::steady_clock::now() + kCameraFreed; std::chrono::steady_clock::now() < end;) {
      rig = std::make_unique<Process>(track(more));
      if (rig->prints(" to " + link_.endpoint, kPatience)) break;
      EXPECT_THAT(rig->output(), ::testing::HasSubstr("wait some seconds if it crashed"));
    }
    return rig;
  }
  /// Every capture is what the camera sent under its number, to the byte, and its pose is about the true one.
  void expect_true_captures(std::size_t first, std::size_t end) const {
    const auto sent = sent_frames();
    const Session session = Session::open_read_only(session_);
    for (std::size_t i = first; i < end; ++i) {
      const Capture capture = session.read(i);
      ASSERT_TRUE(sent.contains(capture.camera_frame_id)) << "capture " << i;
      const RigFrame& truth = recording_->frames[sent.at(capture.camera_frame_id)];
      const std::string bytes(capture.image.bytes.begin(), capture.image.bytes.end());
      EXPECT_TRUE(bytes == read_file(truth.raw_file)) << "capture " << i;
      const auto centre = [](const Rigid3& pose) { return camera_centre(pose); };
      EXPECT_LT((centre(capture.pose.camera_from_object) - centre(truth.camera_from_object)).norm(), 0.01)
          << "capture " << i;
    }
  }

  static std::unique_ptr<TempFolder> folder_;
  static std::unique_ptr<RigRecording> recording_;
  const TempFolder temp_;
  const SecureLink link_{temp_.path()};
  const std::filesystem::path session_ = temp_.path() / "session";
};

std::unique_ptr<TempFolder> CameraOnTheWire::folder_;
std::unique_ptr<RigRecording> CameraOnTheWire::recording_;

TEST_F(CameraOnTheWire, EveryFrameIsAccountedForAndNoKeyframeIsLost) {
  Process camera(serve_camera());
  ASSERT_TRUE(camera.prints("serves", kPatience)) << camera.output();
  Process keeping(desk({"--once"}));
  expect_outcome(run_to_end(track({"--frames", std::to_string(kFrames)})), 0, {"36 frames"});
  expect_outcome(wait_to_end(keeping), 0, {"images added to the model"});
  camera.signal(SIGINT);
  expect_outcome(wait_to_end(camera), 0, {});

  const auto rig = nlohmann::json::parse(read_file(temp_.path() / "tracker.json"));
  const auto& frames = rig["frames"];
  std::uint64_t refused = 0;
  for (const auto& [reason, n] : frames["refused"].items()) refused += n.get<std::uint64_t>();
  const auto kept = frames["sent"].get<std::uint64_t>();
  EXPECT_EQ(frames["grabbed"], kFrames);
  EXPECT_EQ(kept + frames["unsent"].get<std::uint64_t>() + frames["overrun"].get<std::uint64_t>() + refused, kFrames);
  EXPECT_GE(kept, 24u) << "most frames are sharp and show the tags: " << frames;
  EXPECT_EQ(frames["unsent"], 0);
  EXPECT_EQ(rig["source"]["incomplete"], 0);
  EXPECT_EQ(rig["link"]["acknowledged"], kept);

  const auto got = nlohmann::json::parse(read_file(temp_.path() / "desk.json"))["frames"];
  EXPECT_EQ(got["received"], kept);
  EXPECT_EQ(got["lost"], 0);
  const auto captures = captures_of(session_);
  ASSERT_EQ(captures.size(), kept);
  for (std::size_t i = 0; i < captures.size(); ++i) {
    EXPECT_EQ(captures[i].first, captures[0].first);
    EXPECT_EQ(captures[i].second, i + 1);
  }
  expect_true_captures(0, captures.size());
}

TEST_F(CameraOnTheWire, ThePersonWhoHoldsItIsToldWhyFramesAreRefused) {
  const std::filesystem::path strict = recording_->folder / "strict.toml";  // beside the stage that it names
  std::string text = read_file(config());
  text.replace(text.find("max_blur_px = 1000.0"), 20, "max_blur_px = 0.01");
  std::ofstream(strict) << text;
  Process camera(serve_camera() + Words{"--loop"});
  ASSERT_TRUE(camera.prints("serves", kPatience)) << camera.output();
  Process rig(tracker({"run", "--config", strict, "--endpoint", free_address(), "--linger", "0"}));
  EXPECT_TRUE(rig.prints("TOO FAST: MOTION BLUR", kPatience)) << rig.output();
  rig.signal(SIGINT);
  wait_to_end(rig);
  camera.signal(SIGINT);
  expect_outcome(wait_to_end(camera), 0, {});
}

TEST_F(CameraOnTheWire, PreviewNeedsNoCalibration) {
  Process camera(serve_camera() + Words{"--loop"});
  ASSERT_TRUE(camera.prints("serves", kPatience)) << camera.output();
  const std::filesystem::path grabbed = temp_.path() / "frame.png", report = temp_.path() / "preview.json";
  expect_outcome(run_to_end(tracker({"preview", "--source", "aravis:127.0.0.1", "--frames", "3", "--grab", grabbed,
                                     "--json", report})),
                 0, {"focus", "clipped", "tags", "frame.png"});
  const std::filesystem::path series = temp_.path() / "series";
  for (const std::size_t there : {3u, 6u}) {  // what is there is not written over
    expect_outcome(run_to_end(tracker({"preview", "--source", "aravis:127.0.0.1", "--frames", "3", "--grab", series,
                                       "--every", "0.001"})),
                   0, {"saved", "3 frames"});
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(series), {}), there);
  }
  camera.signal(SIGINT);
  expect_outcome(wait_to_end(camera), 0, {});
  const auto said = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(said["frames"], 3);
  EXPECT_EQ(said["width"], 480);
  EXPECT_GE(said["tags"], 4);
  EXPECT_GT(said["focus"], 0.01);
  const RawImage picture = read_image(grabbed);
  EXPECT_EQ(picture.width, 480);
  EXPECT_EQ(picture.height, 360);
}

TEST_F(CameraOnTheWire, ATrackerThatWasKilledComesBackToTheCamera) {
  Process camera(serve_camera());
  ASSERT_TRUE(camera.prints("serves", kPatience)) << camera.output();
  Process keeping(desk());
  const std::string status_address = free_address();
  auto rig = std::make_unique<Process>(track({"--publish", status_address}));
  const CurveKeys desk_keys = load_keys(temp_.path() / "desk.key");
  MonitorSubscriber status({.endpoint = status_address,
                            .keys = desk_keys,
                            .server_public_key = load_public_key(temp_.path() / "tracker.pub")});
  double acknowledged = 0;
  for (const auto end = std::chrono::steady_clock::now() + kPatience;
       acknowledged < 8 && std::chrono::steady_clock::now() < end;)
    if (const auto said = status.next(milliseconds(50))) acknowledged = said->gauges.at("link_acknowledged");
  ASSERT_GE(acknowledged, 8) << rig->output();
  rig->kill();
  const std::uint64_t before = captures_so_far(session_);
  EXPECT_GE(before, static_cast<std::uint64_t>(acknowledged)) << "acknowledged and not there";

  rig = track_again({"--frames", "10"});
  expect_outcome(wait_to_end(*rig), 0, {"10 frames"});
  keeping.signal(SIGINT);
  expect_outcome(wait_to_end(keeping), 0, {"captures="});
  camera.signal(SIGINT);
  expect_outcome(wait_to_end(camera), 0, {});

  // Two runs of the camera, each without a gap and in order.
  const auto captures = captures_of(session_);
  std::map<std::string, std::uint64_t> last;
  for (const auto& [source, sequence] : captures) EXPECT_EQ(sequence, ++last[source]);
  EXPECT_EQ(last.size(), 2u);
  const auto sent = nlohmann::json::parse(read_file(temp_.path() / "tracker.json"));
  EXPECT_EQ(last[captures.back().first], sent["frames"]["sent"]);
  EXPECT_GE(captures.size(), before + 1);
}

TEST_F(CameraOnTheWire, KilledAgainAndAgainNothingAcknowledgedIsLostAndTheModelIsTheSessions) {
  const int kills = wanted_kills();
  if (kills == 0) GTEST_SKIP() << "tests/loopback/attack --kills N runs it";
  Process camera(serve_camera() + Words{"--loop"});
  ASSERT_TRUE(camera.prints("serves", kPatience)) << camera.output();
  std::mt19937 random(21);
  auto keeping = std::make_unique<Process>(desk({"--once"}));
  auto rig = std::make_unique<Process>(track({}));
  for (int killed = 0; killed < kills; ++killed) {
    ASSERT_TRUE(wait_for_captures(session_, captures_so_far(session_) + 1 + random() % 6))
        << rig->output() << keeping->output();
    const bool rig_dies = killed % 2 == 1;  // the last one, too: its successor ends by itself, and the desk with it
    const std::uint64_t before = captures_so_far(session_);
    if (rig_dies) {
      rig->kill();
      rig = track_again(killed + 1 < kills ? Words{} : Words{"--frames", "10"});
    } else {
      keeping->kill();
      keeping = std::make_unique<Process>(desk({"--once"}));
    }
    EXPECT_GE(captures_so_far(session_), before) << "what was kept is gone";
  }
  expect_outcome(wait_to_end(*rig), 0, {"10 frames"});
  expect_outcome(wait_to_end(*keeping), 0, {"images added to the model"});
  camera.signal(SIGINT);
  expect_outcome(wait_to_end(camera), 0, {});

  const auto captures = captures_of(session_);
  std::map<std::string, std::uint64_t> last;
  for (const auto& [source, sequence] : captures) EXPECT_EQ(sequence, ++last[source]) << source;
  EXPECT_EQ(last.size(), static_cast<std::size_t>(1 + kills / 2)) << "a source for each run of the tracker";
  expect_true_captures(0, captures.size());
  const auto built = temp_.path() / "built";
  expect_outcome(run_to_end(reconstructor(
                     {"build", session_, "--mesh", recording_->mesh_file(), "--out", built, "--loss", "0dB"})),
                 0, {});
  expect_same_model(built, session_ / "model");
}

/// A camera that stands still and a lamp that a gantry moves, whose controller writes which place lit which frame: the
/// log of the camera on the wire.
TEST(ALampOnTheWire, EachFrameHasTheLightThatItWasTakenIn) {
  const TempFolder temp;
  SimulationOptions options = sphere_rig(kFrames);
  options.frames = 16;
  options.light_path = "dome";
  options.still_camera = true;
  const RigRecording recording = cached_recording(options, temp.path() / "rig").recording;
  const std::filesystem::path folder = recording.folder, session = temp.path() / "session",
                              report = temp.path() / "desk.json";
  std::ofstream(folder / "rig.toml", std::ios::app) << "\n[gate]\nmin_bright = 0.0\nmax_uncertainty_px = 0.5\n";
  // Round and round: a tracker that keeps up with few of the frames sees every light after some rounds.
  Process camera(tracker({"simulate", "--serve", folder, "--loop", "--log", folder / "sent.csv"}));
  ASSERT_TRUE(camera.prints("serves", kPatience)) << camera.output();
  const std::string address = free_address();
  Process desk(reconstructor({"serve", "--session", session, "--model", "auto", "--headless", "--no-monitor", "--once",
                              "--endpoint", address, "--loss", "0dB", "--json", report}));
  Process rig(patient_run({"--config", folder / "rig.toml", "--endpoint", address}));
  EXPECT_TRUE(wait_for_captures(session, 12)) << rig.output();
  rig.signal(SIGINT);
  expect_outcome(wait_to_end(rig), 0, {"keyframes sent"});
  expect_outcome(wait_to_end(desk), 0, {"chosen: irradiance_field", "images added to the model"});
  camera.signal(SIGINT);
  wait_to_end(camera);

  std::map<std::uint64_t, std::size_t> sent;
  std::ifstream log(folder / "sent.csv");
  char comma = 0;
  std::size_t index = 0;
  for (std::uint64_t id = 0; log >> id >> comma >> index;) sent[id] = index;
  const std::vector<LitView> truth = load_lights(folder / "lights.lp");
  const Session recorded = Session::open_read_only(session);
  ASSERT_GT(recorded.size(), 0u);
  const Rigid3 pose = recorded.read(0).pose.camera_from_object;
  EXPECT_LT((camera_centre(pose) - camera_centre(recording.frames[0].camera_from_object)).norm(), 0.01);
  std::set<std::size_t> lights;
  for (std::uint64_t i = 0; i < recorded.size(); ++i) {
    const Capture capture = recorded.read(i);
    ASSERT_TRUE(sent.contains(capture.camera_frame_id)) << i;
    lights.insert(sent[capture.camera_frame_id]);
    EXPECT_EQ(capture.light.kind, LightKind::kPoint);
    EXPECT_EQ(capture.light.position, truth.at(sent[capture.camera_frame_id]).light.position) << i;
    EXPECT_EQ(capture.pose.camera_from_object.matrix(), pose.matrix()) << i;
  }
  EXPECT_GE(lights.size(), 12u);
  const auto json = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(json["model_choice"]["why"], "the camera stands still and the light moves");
  EXPECT_EQ(json["frames"]["accepted"], recorded.size());
}

}  // namespace
}  // namespace sheen::testing
