// SPDX-License-Identifier: Apache-2.0
// A rig of three cameras, each a GigE Vision endpoint on an address of its own, with its own lens and its own way round
// the object: one tracker for all, or two trackers, and one reconstructor. All are processes of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "common/link/monitor_socket.h"
#include "common/session/session.h"
#include "common/simulation/simulated_rig.h"
#include "common/simulation/test_object.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr std::size_t kCameras = 3;
constexpr int kFrames = kPatienceFactor == 1 ? 20 : 8;  // of each camera; a sanitized program takes seconds for each
constexpr std::array<const char*, kCameras> kNames{"left", "middle", "right"};
constexpr std::array<const char*, kCameras> kAddresses{"127.0.0.1", "127.0.0.2", "127.0.0.3"};
constexpr std::array<int, kCameras> kWidths{480, 440, 400};

bool run(const std::string& command) {
  return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
}

bool write_to(const char* file, const std::string& text) {
  std::ofstream out(file);
  out << text << std::flush;
  return out.good();
}

/// A loopback network of this test's own with three addresses. False where the machine does not allow it.
bool own_network() {
  const std::string user = std::to_string(::getuid()), group = std::to_string(::getgid());
  if (::unshare(CLONE_NEWNET) != 0) {
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
    write_to("/proc/self/setgroups", "deny");
    if (!write_to("/proc/self/uid_map", "0 " + user + " 1") || !write_to("/proc/self/gid_map", "0 " + group + " 1"))
      return false;
  }
  return run("ip link set lo up") && run("ip addr add 127.0.0.2/8 dev lo") && run("ip addr add 127.0.0.3/8 dev lo");
}

SimulationOptions way_of(std::size_t camera) {
  SimulationOptions options;
  options.object = "sphere";
  options.frames = kFrames;
  options.width = kWidths[camera];
  options.height = kWidths[camera] * 3 / 4;
  options.seed = camera + 1;
  options.frame_rate_hz = 8;
  options.bake = {
      .sky_directions = 64, .bounce_directions = 32, .bounces = 1, .area_light_samples = 2, .stage_cell_m = 0.02f};
  return options;
}

/// camera.fx = ... of a rig's file.
std::string numbers_of(const Camera& camera, const std::string& prefix) {
  std::string text;
  const auto add = [&](const char* key, const std::string& value) { text += prefix + key + " = " + value + "\n"; };
  add("width", std::to_string(camera.width));
  add("height", std::to_string(camera.height));
  for (const auto& [key, value] : {std::pair{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}})
    add(key, json(value).dump());
  add("distortion", json(camera.distortion).dump());
  return text;
}

std::string frames(int count) {
  return std::to_string(count) + " frames";
}

std::uint64_t sum_of(const json& counts) {
  std::uint64_t sum = 0;
  for (const json& count : counts) sum += count.get<std::uint64_t>();
  return sum;
}

class SeveralCameras : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!(allowed_ = own_network())) return;
    folder_ = std::make_unique<TempFolder>();
    for (std::size_t i = 0; i < kCameras; ++i)
      recordings_.push_back(cached_recording(way_of(i), folder_->path() / kNames[i]).recording);
    mesh_ = folder_->path() / "coarse.ply";
    const Mesh fine = load_mesh(recordings_[0].mesh_file()).mesh;
    const Eigen::Vector3d centre = bounding_sphere(fine).centre;
    save_ply(make_sphere({}, (fine.vertices[0].cast<double>() - centre).norm(), centre, 2).mesh, mesh_);
  }
  static void TearDownTestSuite() {
    recordings_.clear();
    folder_.reset();
  }
  void SetUp() override {
    if (!allowed_) GTEST_SKIP() << "this machine lets nobody make a network of his own";
  }

  Words camera(std::size_t i) const {
    return tracker({"simulate", "--serve", recordings_[i].folder, "--interface", kAddresses[i], "--log", log_of(i)});
  }
  std::filesystem::path log_of(std::size_t i) const { return temp_.path() / (std::string(kNames[i]) + ".csv"); }
  std::unique_ptr<Process> start_camera(std::size_t i, const Words& more = {}) const {
    auto started = std::make_unique<Process>(camera(i) + more);
    EXPECT_TRUE(started->prints("serves", kPatience)) << started->output();
    return started;
  }
  std::vector<std::unique_ptr<Process>> start_cameras(const Words& more = {}) const {
    std::vector<std::unique_ptr<Process>> all;
    for (std::size_t i = 0; i < kCameras; ++i) all.push_back(start_camera(i, more));
    return all;
  }
  static void stop(std::vector<std::unique_ptr<Process>>& cameras) {
    for (const auto& camera : cameras) camera->signal(SIGINT);
    for (const auto& camera : cameras) expect_outcome(wait_to_end(*camera), 0, {});
  }
  /// A rig of some of the cameras, by their numbers.
  std::filesystem::path rig_of(const std::string& name, const std::vector<std::size_t>& cameras) const {
    const std::filesystem::path file = temp_.path() / name;
    std::ofstream out(file);
    out << "[stage]\nfile = " << recordings_[0].stage_file()
        << "\n[gate]\nmax_blur_px = 1000.0\nmax_uncertainty_px = 0.5\n";  // the views are far apart
    for (const std::size_t i : cameras)
      out << "[[cameras]]\nname = \"" << kNames[i] << "\"\nsource.uri = \"aravis:" << kAddresses[i] << "\"\n"
          << numbers_of(recordings_[i].camera, "camera.");
    return file;
  }
  std::filesystem::path rig_of_one(const std::string& name, std::size_t i) const {
    const std::filesystem::path file = temp_.path() / name;
    std::ofstream(file) << "[stage]\nfile = " << recordings_[i].stage_file()
                        << "\n[gate]\nmax_blur_px = 1000.0\nmax_uncertainty_px = 0.5\n[source]\nuri = \"aravis:"
                        << kAddresses[i] << "\"\n[camera]\n"
                        << numbers_of(recordings_[i].camera, "");
    return file;
  }
  json read_json(const char* name) const { return json::parse(read_file(temp_.path() / name)); }

  /// What the camera sent of its recording, by frame id.
  std::map<std::uint64_t, std::size_t> sent_by(std::size_t i) const {
    std::map<std::uint64_t, std::size_t> sent;
    std::ifstream log(log_of(i));
    char comma = 0;
    std::size_t index = 0;
    for (std::uint64_t id = 0; log >> id >> comma >> index;) sent[id] = index;
    return sent;
  }
  /// It is, to the byte, what the camera sent under its number, has the camera's own numbers, and its true pose.
  void expect_true(const Capture& capture, std::size_t camera) const {
    const auto sent = sent_by(camera);
    ASSERT_TRUE(sent.contains(capture.camera_frame_id)) << capture.name;
    const RigFrame& truth = recordings_[camera].frames[sent.at(capture.camera_frame_id)];
    EXPECT_TRUE(std::string(capture.image.bytes.begin(), capture.image.bytes.end()) == read_file(truth.raw_file))
        << capture.name;
    EXPECT_EQ(capture.camera.width, kWidths[camera]);
    EXPECT_NEAR(capture.camera.fx, recordings_[camera].camera.fx, 1e-9);
    EXPECT_LT((camera_centre(capture.pose.camera_from_object) - camera_centre(truth.camera_from_object)).norm(), 0.01)
        << capture.name;
  }
  /// One run of the camera's tracker: every frame is kept, refused or lost, for a reason each.
  static void expect_accounted(const json& report) {
    const json& frames = report["frames"];
    EXPECT_EQ(frames["camera"], frames["received"].get<int>() + frames["lost"].get<int>());
    EXPECT_EQ(frames["grabbed"].get<std::uint64_t>(), frames["sent"].get<std::uint64_t>() + sum_of(frames["refused"]) +
                                                          frames["overrun"].get<std::uint64_t>() +
                                                          frames["unsent"].get<std::uint64_t>());
  }

  static inline bool allowed_ = false;
  static inline std::unique_ptr<TempFolder> folder_;
  static inline std::vector<RigRecording> recordings_;
  static inline std::filesystem::path mesh_;  ///< the object of fewer triangles: what it looks like is not tested here
  const TempFolder temp_;
  const std::filesystem::path session_ = temp_.path() / "session";
};

TEST_F(SeveralCameras, EveryFrameOfEachIsAccountedForInOneSession) {
  auto cameras = start_cameras();
  const SecureLink link(temp_.path());
  Process desk(
      serve(mesh_, session_, link.reconstructor_options() + Words{"--once", "--json", temp_.path() / "desk.json"}));
  expect_outcome(run_to_end(patient_run({"--config", rig_of("rig.toml", {0, 1, 2}), "--frames", std::to_string(kFrames),
                                         "--json", temp_.path() / "tracker.json"}) +
                            link.tracker_options()),
                 0,
                 {"left aravis:127.0.0.1, middle aravis:127.0.0.2", frames(3 * kFrames), "left: " + frames(kFrames),
                  "right: " + frames(kFrames)});
  expect_outcome(wait_to_end(desk), 0, {"images added to the model"});
  stop(cameras);

  const json report = read_json("tracker.json");
  expect_accounted(report);
  EXPECT_EQ(report["frames"]["grabbed"], 3 * kFrames);
  EXPECT_EQ(report["source"]["incomplete"], 0);
  const auto kept = report["frames"]["sent"].get<std::uint64_t>();
  EXPECT_EQ(report["link"]["acknowledged"], kept);
  EXPECT_GE(kept, 3u * kFrames * 6 / 10) << "most frames are sharp and show the tags";
  std::map<std::string, std::uint64_t> kept_by;
  for (const char* name : kNames) {
    const json& own = report["cameras"][name];
    expect_accounted(own);
    EXPECT_EQ(own["frames"]["grabbed"], kFrames) << name;
    EXPECT_GT(own["frames"]["sent"], 0) << name;
    kept_by[name] = own["frames"]["sent"];
  }
  EXPECT_EQ(kept_by["left"] + kept_by["middle"] + kept_by["right"], kept);

  const json desk_report = read_json("desk.json");
  EXPECT_EQ(desk_report["frames"]["received"], kept);
  EXPECT_EQ(desk_report["frames"]["lost"], 0);
  ASSERT_EQ(desk_report["trackers"].size(), 1u);
  EXPECT_EQ(desk_report["trackers"][0]["judged"].get<std::uint64_t>(),
            kept + sum_of(report["frames"]["refused"]) + report["frames"]["unsent"].get<std::uint64_t>());

  const Session session = Session::open_read_only(session_);
  ASSERT_EQ(session.size(), kept);
  std::map<std::string, std::uint64_t> stored_by;
  std::string source;
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const Capture capture = session.read(i);
    if (i == 0) source = capture.source_session;
    EXPECT_EQ(capture.source_session, source);
    EXPECT_EQ(capture.sequence, i + 1);
    const auto name = capture.name.substr(0, capture.name.find(' '));
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    ASSERT_NE(found, kNames.end()) << capture.name;
    ++stored_by[name];
    expect_true(capture, static_cast<std::size_t>(found - kNames.begin()));
  }
  EXPECT_EQ(stored_by, kept_by);
}

TEST_F(SeveralCameras, OneThatIsUnpluggedStopsNoOther) {
  auto cameras = start_cameras({"--loop"});
  const std::string status_address = free_address();
  Process rig(tracker({"run", "--config", rig_of("rig.toml", {0, 1, 2}), "--endpoint", free_address(), "--linger", "0",
                       "--publish", status_address, "--json", temp_.path() / "tracker.json"}));
  MonitorSubscriber subscriber({.endpoint = status_address});
  Status said;
  std::array<bool, kCameras> silent{};  // at any time, as the tracker says it
  const auto listen = [&] {
    auto status = subscriber.next(milliseconds(50));
    if (!status) return false;
    said = *std::move(status);
    for (std::size_t i = 0; i < kCameras; ++i)
      silent[i] |=
          said.message.find(std::string(kNames[i]) + ": camera " + kAddresses[i] + " has stopped") != std::string::npos;
    return true;
  };
  const auto grabbed = [&](const char* name) { return said.gauges[std::string(name) + "/frames_grabbed"]; };
  const auto until = [&](const std::function<bool()>& holds) {
    for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
      listen();
      if (said.clock_ns != 0 && holds()) return true;
    }
    return false;
  };
  ASSERT_TRUE(until([&] { return grabbed("left") >= 4 && grabbed("middle") >= 4 && grabbed("right") >= 4; }))
      << rig.output();

  cameras[1]->kill();
  ASSERT_TRUE(until([&] { return said.state == SourceState::kStale; })) << said.message;
  EXPECT_THAT(said.message, ::testing::HasSubstr("middle: camera 127.0.0.2 has stopped delivering"));
  const double left = grabbed("left"), middle = grabbed("middle"), right = grabbed("right");
  ASSERT_TRUE(until([&] { return grabbed("left") >= left + 24 && grabbed("right") >= right + 24; })) << said.message;
  EXPECT_LE(grabbed("middle"), middle + 1) << "it is unplugged";
  EXPECT_TRUE(rig.prints("MIDDLE: CAMERA 127.0.0.2 HAS STOPPED DELIVERING", kPatience)) << rig.output();

  cameras[1] = start_camera(1, {"--loop"});
  ASSERT_TRUE(until([&] { return grabbed("middle") >= middle + 8; })) << rig.output() << said.message;
  ASSERT_TRUE(until([&] { return said.state == SourceState::kLive; })) << said.message;
  rig.signal(SIGINT);
  wait_to_end(rig);
  stop(cameras);
  while (listen()) {
  }
  const json report = read_json("tracker.json");
  expect_accounted(report);
  // On a loaded machine any camera may be silent for so long that it is opened again: never one that was not silent.
  for (std::size_t i = 0; i < kCameras; ++i)
    if (!silent[i]) EXPECT_EQ(report["cameras"][kNames[i]]["source"]["reopened"], 0) << kNames[i];
  EXPECT_GE(report["cameras"]["middle"]["source"]["reopened"], 1);
  // Nobody received anything: the account of each camera says so.
  std::uint64_t lost = 0;
  for (const char* name : kNames) {
    expect_accounted(report["cameras"][name]);
    lost += report["cameras"][name]["frames"]["lost"].get<std::uint64_t>();
  }
  EXPECT_EQ(lost, report["frames"]["lost"]);
}

TEST_F(SeveralCameras, OneThatIsNotThereIsNamed) {
  const auto camera = start_camera(0);
  expect_outcome(run_to_end(patient_run({"--config", rig_of("rig.toml", {0, 2}), "--endpoint", free_address()})), 1,
                 {"camera right: camera 127.0.0.3 does not answer"});
  expect_outcome(run_to_end(tracker({"doctor", "--config", rig_of("rig.toml", {0, 2})})), 1,
                 {"camera settings of left", "camera settings of right", "127.0.0.3 does not answer"});
}

TEST_F(SeveralCameras, TwoTrackersFeedOneSession) {
  auto cameras = start_cameras();
  std::filesystem::create_directory(temp_.path() / "a");
  std::filesystem::create_directory(temp_.path() / "b");
  const SecureLink a(temp_.path() / "a");
  const SecureLink b(temp_.path() / "b");
  const CurveKeys desk_keys = load_keys(temp_.path() / "a" / "desk.key");  // one reconstructor, one key
  std::ofstream(temp_.path() / "b" / "allowed", std::ios::trunc) << desk_keys.public_key << " reconstructor desk\n";
  Process desk(serve(
      mesh_, session_,
      a.reconstructor_options() + Words{"--endpoint", b.endpoint, "--tracker-key", temp_.path() / "b" / "tracker.pub",
                                        "--once", "--json", temp_.path() / "desk.json"}));
  Process first(patient_run({"--config", rig_of("two.toml", {0, 1}), "--frames", std::to_string(kFrames), "--json",
                             temp_.path() / "a.json"}) +
                a.tracker_options());
  Process second(patient_run({"--config", rig_of_one("one.toml", 2), "--frames", std::to_string(kFrames), "--json",
                              temp_.path() / "b.json"}) +
                 b.tracker_options());
  expect_outcome(wait_to_end(first), 0, {frames(2 * kFrames)});
  expect_outcome(wait_to_end(second), 0, {frames(kFrames)});
  expect_outcome(wait_to_end(desk), 0, {"images added to the model"});
  stop(cameras);

  const json of_a = read_json("a.json"), of_b = read_json("b.json"), got = read_json("desk.json");
  const auto kept_a = of_a["frames"]["sent"].get<std::uint64_t>(), kept_b = of_b["frames"]["sent"].get<std::uint64_t>();
  EXPECT_EQ(of_a["link"]["acknowledged"], kept_a);
  EXPECT_EQ(of_b["link"]["acknowledged"], kept_b);
  EXPECT_FALSE(of_b.contains("cameras"));
  EXPECT_EQ(got["frames"]["received"], kept_a + kept_b);
  EXPECT_EQ(got["frames"]["lost"], 0);
  ASSERT_EQ(got["trackers"].size(), 2u);
  EXPECT_EQ(got["trackers"][0]["endpoint"], a.endpoint);
  EXPECT_EQ(got["trackers"][0]["received"], kept_a);
  EXPECT_EQ(got["trackers"][1]["received"], kept_b);
  EXPECT_EQ(got["trackers"][1]["judged"].get<std::uint64_t>(), kept_b + sum_of(of_b["frames"]["refused"]));

  // Each run of a tracker counts by itself, and each holds out its own views.
  const Session session = Session::open_read_only(session_);
  ASSERT_EQ(session.size(), kept_a + kept_b);
  std::map<std::string, std::uint64_t> last;
  std::set<std::pair<std::string, std::uint64_t>> judged, reported;
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const Capture capture = session.read(i);
    EXPECT_EQ(capture.sequence, ++last[capture.source_session]) << capture.name;
    if (capture.sequence % 8 == 0) judged.emplace(capture.source_session, capture.sequence);
    const bool named = capture.name.starts_with("left ") || capture.name.starts_with("middle ");
    expect_true(capture, named ? (capture.name.starts_with("left ") ? 0 : 1) : 2);
  }
  ASSERT_EQ(last.size(), 2u);
  for (const auto& [source, count] : last) EXPECT_TRUE(count == kept_a || count == kept_b) << source;
  for (const json& view : got["held_out"]["per_view"]) reported.emplace(view["source_session"], view["sequence"]);
  EXPECT_EQ(reported, judged);
  EXPECT_EQ(got["frames"]["held_out"], judged.size());
}

}  // namespace
}  // namespace sheen::testing
