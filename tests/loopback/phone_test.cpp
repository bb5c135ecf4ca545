// SPDX-License-Identifier: Apache-2.0
// A telephone as the camera: a real HTTP server on this machine sends the frames of the simulated rig as JPEG, and the
// programs, processes of their own, take them as their camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/files.h"
#include "common/session/session.h"
#include "common/simulation/simulated_rig.h"
#include "tests/loopback/daemons.h"
#include "tests/loopback/phone.h"
#include "tests/loopback/sphere_rig.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kFrames = 24;
constexpr milliseconds kBetween{100 * kPatienceFactor};

class Phone : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TempFolder>();
    recording_ =
        std::make_unique<RigRecording>(cached_recording(sphere_rig(kFrames), folder_->path() / "rig").recording);
    jpegs_ = jpegs_of(*recording_);
    // So few views round the object are far apart: what would be a fast motion for a hand.
    const std::string rig = read_file(recording_->folder / "rig.toml");
    std::ofstream(config()) << rig.substr(0, rig.find("[source]"))
                            << "[gate]\nmax_blur_px = 1000.0\nmax_uncertainty_px = 0.5\n";
  }
  static void TearDownTestSuite() {
    recording_.reset();
    folder_.reset();
  }
  static std::filesystem::path config() { return recording_->folder / "phone.toml"; }

  std::string source(const std::string& user = {}) const { return "video:" + phone_.address(user); }
  Words track(const Words& more) const {
    return patient_run(
               {"--config", config(), "--source", source("me:hunter2"), "--json", report_, "--endpoint", address_}) +
           more;
  }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(report_)); }
  /// Of the true pose that is nearest, millimetres.
  double error_mm(const Capture& capture) const {
    double least = INFINITY;
    for (const RigFrame& truth : recording_->frames)
      least = std::min(
          least, (camera_centre(capture.pose.camera_from_object) - camera_centre(truth.camera_from_object)).norm());
    return 1e3 * least;
  }

  static std::unique_ptr<TempFolder> folder_;
  static std::unique_ptr<RigRecording> recording_;
  static std::vector<std::string> jpegs_;
  const TempFolder temp_;
  const std::filesystem::path session_ = temp_.path() / "session", report_ = temp_.path() / "tracker.json";
  const std::string address_ = free_address();
  MjpegServer phone_{again_and_again(jpegs_), {.between = kBetween, .user_and_password = "me:hunter2"}};
};

std::unique_ptr<TempFolder> Phone::folder_;
std::unique_ptr<RigRecording> Phone::recording_;
std::vector<std::string> Phone::jpegs_;

TEST_F(Phone, ItsStreamIsTrackedAndCaptured) {
  Process desk(serve(recording_->mesh_file(), session_, {"--endpoint", address_, "--once"}));
  const Outcome outcome = run_to_end(track({"--frames", std::to_string(kFrames)}));
  expect_outcome(outcome, 0, {"24 frames", "me:***@127.0.0.1", "its exposure is not known", "Lock exposure"});
  EXPECT_THAT(outcome.output, Not(HasSubstr("hunter2")));
  expect_outcome(wait_to_end(desk), 0, {"images added to the model"});
  const auto frames = report()["frames"];
  EXPECT_GE(frames["sent"], 14) << frames;
  const Session session = Session::open_read_only(session_);
  ASSERT_EQ(session.size(), frames["sent"]);
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const Capture capture = session.read(i);
    EXPECT_LT(error_mm(capture), 3) << "capture " << i;
    EXPECT_EQ(capture.exposure.exposure_s, 0);
    EXPECT_FALSE(capture.exposure.locked);
  }
}

TEST_F(Phone, ThatIsAwayForAWhileGoesOn) {
  Process rig(track({}));
  ASSERT_TRUE(rig.prints(" to " + address_, kPatience)) << rig.output();
  phone_.refuses = true;
  EXPECT_TRUE(rig.prints("is opened again as soon as it answers", kPatience)) << rig.output();
  phone_.refuses = false;
  EXPECT_TRUE(rig.prints("delivers again, after", kPatience)) << rig.output();
  rig.signal(SIGINT);
  const Outcome outcome = wait_to_end(rig);
  EXPECT_EQ(report()["source"]["reopened"], 1) << outcome.output;
  EXPECT_THAT(outcome.output, Not(HasSubstr("hunter2")));
}

// Automatic exposure: the brightness swings by a fifth of the middle twice on the way round the object.
TEST_F(Phone, AnExposureThatDriftsIsEstimatedFromItsImages) {
  const auto swings = [](std::size_t i) {
    const double gain = 0.8 + 0.2 * std::sin(4 * M_PI * static_cast<double>(i) / kFrames);
    return Gains{gain, gain, gain};
  };
  MjpegServer phone(again_and_again(jpegs_of(*recording_, swings)), {.between = kBetween});
  Process desk(serve(recording_->mesh_file(), session_, {"--endpoint", address_, "--once"}));
  expect_outcome(run_to_end(patient_run({"--config", config(), "--source", "video:" + phone.address(), "--endpoint",
                                         address_, "--frames", std::to_string(kFrames)})),
                 0, {"24 frames"});
  expect_outcome(wait_to_end(desk), 0, {"images added to the model"});
  const auto scores = [&](const std::string& exposure) {
    const std::filesystem::path scene = temp_.write(exposure + ".toml", "[images]\nexposure = \"" + exposure + "\"\n");
    const std::filesystem::path model = temp_.path() / exposure, report = temp_.path() / (exposure + ".json");
    expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", recording_->mesh_file(), "--config", scene,
                                             "--no-refine", "--out", model})),
                   0, {});
    expect_outcome(run_to_end(reconstructor({"evaluate", model, session_, "--json", report})), 0, {});
    return nlohmann::json::parse(read_file(report));
  };
  const auto taken_as_it_is = scores("known"), estimated = scores("estimate");
  const auto psnr = [](const nlohmann::json& judged, const char* of, const char* which) {
    return judged[of][which].get<double>();
  };
  EXPECT_GT(psnr(estimated, "constant", "psnr_db"), psnr(taken_as_it_is, "constant", "psnr_db") + 1);
  EXPECT_GT(psnr(estimated, "object", "psnr_gain_aligned_db"),
            psnr(taken_as_it_is, "object", "psnr_gain_aligned_db") + 0.1);
  RecordProperty("known", taken_as_it_is["object"].dump() + taken_as_it_is["constant"].dump());
  RecordProperty("estimate", estimated["object"].dump() + estimated["constant"].dump());
}

TEST_F(Phone, CalibrateTakesItsViewsFromIt) {
  MjpegServer held_still(again_and_again(jpegs_, 4), {.between = kBetween});
  const std::filesystem::path views = temp_.path() / "views";
  const Outcome outcome = run_to_end(
      tracker({"calibrate", "--source", "video:" + held_still.address(), "--target",
               "stage:" + recording_->stage_file().string(), "--keep", views, "--frames", "60", "--page", "0"}));
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("the picture is at http://127.0.0.1:"), HasSubstr("saved"),
                                    HasSubstr(" views"), HasSubstr("exposure is not known")));
  EXPECT_GE(std::distance(std::filesystem::directory_iterator(views), {}), 2);
}

TEST_F(Phone, TheDoctorOpensItAndWarnsOfWhatItDoesNotTell) {
  const std::filesystem::path rig = recording_->folder / "doctor.toml";  // beside the stage that it names
  std::ofstream(rig) << read_file(config()) << "[source]\nuri = \"" << source("me:hunter2") << "\"\n";
  const Outcome outcome = run_to_end(tracker({"doctor", "--config", rig}));
  expect_outcome(outcome, 0, {"me:***@127.0.0.1", "its exposure is not known"});
  EXPECT_THAT(outcome.output, AllOf(::testing::ContainsRegex("WARN[ \t]+camera settings"), Not(HasSubstr("hunter2"))));
}

TEST_F(Phone, CtrlCEndsWhatWaitsForIt) {
  phone_.silent = true;
  for (const Words& command : {track({}), tracker({"preview", "--source", source("me:hunter2")})}) {
    const std::uint64_t before = phone_.callers();
    Process waiting(command);
    while (phone_.callers() < before + 2 && waiting.running()) std::this_thread::sleep_for(milliseconds(5));
    waiting.signal(SIGINT);  // once it was asked for the password, and has told it
    expect_outcome(wait_to_end(waiting), 1, {"stopped before the source was open"});
    phone_.hangs_up = true;  // it takes the next caller
  }
}

}  // namespace
}  // namespace sheen::testing
