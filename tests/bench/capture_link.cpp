// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/capture_link.h"

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/link/monitor_socket.h"
#include "common/simulation/simulated_rig.h"
#include "tests/bench/process_state.h"
#include "tests/bench/tcp_relay.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Process;
using testing::Words;
using testing::operator+;
using Clock = std::chrono::steady_clock;

constexpr seconds kPatience{60};
constexpr double kFaultRate_hz = 15;
constexpr seconds kWatched{20};

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Throws Error when it never happens.
void wait_for(const std::string& what, const std::function<bool()>& happened) {
  for (const auto begin = Clock::now(); !happened(); std::this_thread::sleep_for(milliseconds(2)))
    if (Clock::now() - begin > kPatience) throw Error("waited in vain for " + what);
}

/// Small in detail and as large as a camera's images: what is measured is the way of the bytes.
RigRecording recorded(const std::filesystem::path& folder) {
  SimulationOptions options;
  options.object = "sphere";
  options.frames = 40;
  options.bake = {
      .sky_directions = 64, .bounce_directions = 32, .bounces = 1, .area_light_samples = 2, .stage_cell_m = 0.02f};
  RigRecording recording = cached_recording(options, folder).recording;
  // Every frame is a keyframe: the hardest case.
  std::ofstream(recording.folder / "rig.toml", std::ios::app)
      << "\n[gate]\nmax_blur_px = 1000.0\nmax_uncertainty_px = 1.0\nmin_angle_deg = 0.0\nmin_distance_m = 0.0\n";
  return recording;
}

/// The command lines of one capture, in a folder of its own.
class CaptureCommands {
 public:
  explicit CaptureCommands(const RigRecording& recording) : recording_(recording) {}

  Words camera(double rate_hz) const {
    return testing::tracker({"simulate", "--serve", recording_.folder, "--rate", std::to_string(rate_hz), "--loop"});
  }
  Words rig(const Words& more = {}) const {
    return testing::tracker({"run", "--config", recording_.folder / "rig.toml", "--json", file("rig.json")}) +
           link_.tracker_options() + more;
  }
  Words desk(const Words& more = {}, const std::string& endpoint = "") const {
    return testing::serve(recording_.mesh_file(), session(),
                          Words{"--endpoint", endpoint.empty() ? link_.endpoint : endpoint, "--keys", file("desk.key"),
                                "--tracker-key", file("tracker.pub"), "--json", file("desk.json")} +
                              more);
  }
  std::filesystem::path session() const { return file("session"); }
  std::filesystem::path file(const char* name) const { return temp_.path() / name; }
  const testing::SecureLink& link() const { return link_; }
  nlohmann::json report(const char* name) const { return nlohmann::json::parse(read_file(file(name))); }
  std::uint64_t captures() const { return testing::captures_so_far(session()); }
  /// Captures that are missing between those that are there.
  std::uint64_t gaps() const {
    std::map<std::string, std::uint64_t> last;
    std::uint64_t missing = 0;
    for (const auto& [source, sequence] : testing::captures_of(session())) {
      missing += sequence - last[source] - 1;
      last[source] = sequence;
    }
    return missing;
  }

 private:
  const RigRecording& recording_;
  const TempFolder temp_;
  const testing::SecureLink link_{temp_.path()};
};

/// A camera, both programs, and some captures on the disk.
struct RunningCapture {
  /// `endpoint`: where the reconstructor finds the tracker, if not at its own.
  explicit RunningCapture(const CaptureCommands& c, const Words& rig_options = {}, const std::string& endpoint = "")
      : commands(c),
        camera(std::make_unique<Process>(c.camera(kFaultRate_hz))),
        desk(std::make_unique<Process>(c.desk({}, endpoint))) {
    wait_for("the camera", [this] { return camera->prints("serves", kPatience); });
    rig = std::make_unique<Process>(c.rig(rig_options));
    wait_for("ten captures: " + rig->output(), [&] { return c.captures() >= 10; });
  }
  void wait_for_another(std::uint64_t than) const {
    wait_for("another capture", [&] { return commands.captures() > than; });
  }
  void end() const {
    rig->signal(SIGINT);
    rig->wait(kPatience);
    desk->signal(SIGINT);
    desk->wait(kPatience);
  }

  const CaptureCommands& commands;
  std::unique_ptr<Process> camera, desk, rig;
};

void measure_rate(GoalReport& report, const RigRecording& recording, int rate_hz, int frames, bool latency) {
  const CaptureCommands commands(recording);
  Process camera(commands.camera(rate_hz));
  wait_for("the camera", [&] { return camera.prints("serves", kPatience); });
  Process desk(commands.desk({"--once"}));
  Process rig(commands.rig({"--frames", std::to_string(frames)}));
  if (!rig.wait(seconds(frames / rate_hz) + kPatience) || !desk.wait(kPatience))
    throw Error("the capture at " + std::to_string(rate_hz) + " frames/s does not end:\n" + rig.output());
  const nlohmann::json sent = commands.report("rig.json"), stored = commands.report("desk.json");
  const std::string of =
      ", " + std::to_string(rate_hz) + " frames/s of 1024x768, " + std::to_string(frames) + " frames";
  if (latency) {
    const auto& ms = stored["latency_ms"];
    report.add(at_most(15, {}, "from the camera to the disk" + of + ", median", ms["p50"], "ms"));
    report.add(at_most(25, {}, "from the camera to the disk" + of + ", p95", ms["p95"], "ms"));
    report.add(at_most(33, {}, "from the camera to the disk" + of + ", p99", ms["p99"], "ms"));
  }
  const auto& f = sent["frames"];
  report.add(at_most(0, {}, "frames lost" + of,
                     f["missed"].get<double>() + f["overrun"].get<double>() + f["unsent"].get<double>() +
                         f["sent"].get<double>() - stored["frames"]["received"].get<double>(),
                     "",
                     {{"missed by the tracker", f["missed"]},
                      {"overrun", f["overrun"]},
                      {"refused", f["grabbed"].get<double>() - f["sent"].get<double>() - f["unsent"].get<double>() -
                                      f["overrun"].get<double>()}}));
}

/// A process that listens to a tracker's status until it is stopped, as a laptop that is closed.
class StoppedMonitor {
 public:
  explicit StoppedMonitor(const SubscriberOptions& options) : pid_(fork()) {
    if (pid_ != 0) return;
    for (MonitorSubscriber status(options);;) status.next(milliseconds(100));
  }
  ~StoppedMonitor() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  StoppedMonitor(const StoppedMonitor&) = delete;
  StoppedMonitor& operator=(const StoppedMonitor&) = delete;
  void stop() const { kill(pid_, SIGSTOP); }

 private:
  pid_t pid_;
};

struct Watched {
  double p99_ms = 0, grown_mb = 0;
};

/// A capture whose status nobody hears, or somebody who has stopped listening.
Watched capture_watched(const RigRecording& recording, bool monitor_stops) {
  const CaptureCommands commands(recording);
  const std::string address = testing::free_address();
  RunningCapture capture(commands, {"--publish", address});
  std::optional<StoppedMonitor> monitor;
  if (monitor_stops) {
    monitor.emplace(SubscriberOptions{.endpoint = address,
                                      .keys = load_keys(commands.file("desk.key")),
                                      .server_public_key = load_public_key(commands.file("tracker.pub"))});
    std::this_thread::sleep_for(seconds(1));
    monitor->stop();
  }
  const double before = resident_mb(capture.rig->id());
  std::this_thread::sleep_for(kWatched);
  const double grown = resident_mb(capture.rig->id()) - before;
  capture.end();
  return {commands.report("desk.json")["latency_ms"]["p99"], grown};
}

void measure_stopped_monitor(GoalReport& report, const RigRecording& recording) {
  const Watched alone = capture_watched(recording, false), watched = capture_watched(recording, true);
  report.add(at_most(1, {}, "a monitor stops: latency to the disk, p99, longer by", watched.p99_ms - alone.p99_ms, "ms",
                     {{"without it", alone.p99_ms}}));
  report.add(at_most(16, {}, "a monitor stops: the tracker's memory grows by", watched.grown_mb, "MB",
                     {{"without it", alone.grown_mb}}));
}

void measure_killed_desk(GoalReport& report, const RigRecording& recording) {
  const CaptureCommands commands(recording);
  RunningCapture capture(commands);
  const std::uint64_t before = commands.captures();
  capture.desk->kill();
  std::this_thread::sleep_for(milliseconds(500));
  const auto begin = Clock::now();
  capture.desk = std::make_unique<Process>(commands.desk());
  wait_for("the link", [&] { return capture.desk->prints("waiting for a tracker", kPatience); });
  const double opened = ms_since(begin);
  capture.wait_for_another(before);
  const double resumed = ms_since(begin);
  capture.end();
  report.add(at_most(100, {}, "reconstructor killed: from its link's opening to the next capture on the disk",
                     resumed - opened, "ms", {{"from its start", resumed}}));
  report.add(at_most(0, {}, "reconstructor killed: keyframes lost", static_cast<double>(commands.gaps()), ""));
}

void measure_killed_rig(GoalReport& report, const RigRecording& recording) {
  const CaptureCommands commands(recording);
  RunningCapture capture(commands);
  const auto begin = Clock::now();
  capture.rig->kill();
  wait_for("the news", [&] { return capture.desk->prints("the tracker is disconnected", kPatience); });
  const double noticed = ms_since(begin);
  const std::uint64_t before = commands.captures();
  // As a supervisor does: the camera holds on to the dead tracker for some seconds.
  while (commands.captures() == before) {
    capture.rig = std::make_unique<Process>(commands.rig());
    while (capture.rig->running() && commands.captures() == before) std::this_thread::sleep_for(milliseconds(2));
    if (ms_since(begin) > 60'000) throw Error("the tracker does not come back:\n" + capture.rig->output());
  }
  const double back = ms_since(begin);
  capture.end();
  report.add(at_most(200, {}, "tracker killed: until the reconstructor says so", noticed, "ms"));
  report.add(at_most(4000, {}, "tracker killed and started again: until the next capture", back, "ms"));
}

void measure_cut_link(GoalReport& report, const RigRecording& recording) {
  const CaptureCommands commands(recording);
  TcpRelay relay(commands.link().endpoint);
  RunningCapture capture(commands, {}, relay.endpoint());
  const auto cut = Clock::now();
  relay.cut();
  wait_for("the news", [&] { return capture.desk->prints("the tracker is disconnected", kPatience); });
  const double noticed = ms_since(cut);
  const std::uint64_t before = commands.captures();
  const auto mended = Clock::now();
  relay.mend();
  capture.wait_for_another(before);
  const double resumed = ms_since(mended);
  capture.end();
  report.add(at_most(2000, {}, "link cut: until the reconstructor says so", noticed, "ms"));
  report.add(at_most(1000, {}, "link mended: until the next capture", resumed, "ms"));
  report.add(at_most(0, {}, "link cut: keyframes lost", static_cast<double>(commands.gaps()), ""));
}

void measure_unplugged_camera(GoalReport& report, const RigRecording& recording) {
  const CaptureCommands commands(recording);
  const std::string address = testing::free_address();
  RunningCapture capture(commands, {"--publish", address});
  MonitorSubscriber status({.endpoint = address,
                            .keys = load_keys(commands.file("desk.key")),
                            .server_public_key = load_public_key(commands.file("tracker.pub"))});
  const auto until = [&](SourceState state) {
    wait_for(to_string(state), [&] {
      const auto said = status.next(milliseconds(20));
      return said && said->state == state;
    });
  };
  until(SourceState::kLive);
  const auto unplugged = Clock::now();
  capture.camera->kill();
  until(SourceState::kStale);
  const double stale = ms_since(unplugged);
  std::this_thread::sleep_for(seconds(1));
  capture.camera = std::make_unique<Process>(commands.camera(kFaultRate_hz));
  wait_for("the camera", [&] { return capture.camera->prints("serves", kPatience); });
  const std::uint64_t before = commands.captures();
  const auto plugged = Clock::now();
  capture.wait_for_another(before);
  const double back = ms_since(plugged);
  capture.end();
  report.add(at_most(200, {}, "camera unplugged: until the tracker says so", stale, "ms"));
  report.add(at_most(1000, {}, "camera there again: until the next capture", back, "ms"));
}

void measure_wrong_key(GoalReport& report, const RigRecording& recording) {
  const CaptureCommands commands(recording);
  RunningCapture capture(commands);
  const TempFolder stranger_keys;
  const auto begin = Clock::now();
  CaptureReceiver stranger({.endpoint = commands.link().endpoint,
                            .keys = generate_keys(stranger_keys.path(), "stranger"),
                            .server_public_key = load_public_key(commands.file("tracker.pub"))});
  wait_for("the refusal", [&] { return capture.rig->prints("refused", kPatience); });
  const double logged = ms_since(begin);
  const bool got = stranger.next(seconds(1)).has_value();
  const std::uint64_t before = commands.captures();
  capture.wait_for_another(before);
  capture.end();
  report.add(at_most(100, {}, "wrong key: until it is logged", logged, "ms"));
  report.add(at_most(0, {}, "wrong key: captures delivered", got, ""));
}

}  // namespace

void measure_link(GoalReport& report) {
  const TempFolder temp;
  const RigRecording recording = recorded(temp.path() / "rig");
  measure_rate(report, recording, 30, 600, true);
  measure_rate(report, recording, 60, 600, false);
  measure_killed_desk(report, recording);
  measure_killed_rig(report, recording);
  measure_cut_link(report, recording);
  measure_unplugged_camera(report, recording);
  measure_wrong_key(report, recording);
  measure_stopped_monitor(report, recording);
}

}  // namespace sheen
