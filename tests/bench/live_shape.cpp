// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/live_shape.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/errors.h"
#include "common/geometry/mesh_io.h"
#include "common/simulation/simulated_rig.h"
#include "tests/bench/process_state.h"
#include "tests/bench/reconstructor_runs.h"
#include "tests/bench/surfaces_apart.h"
#include "tests/loopback/daemons.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using testing::Process;
using testing::Words;
using testing::operator+;
using Clock = std::chrono::steady_clock;

constexpr int kFrames = 126, kManyFrames = 640;
constexpr double kRate_hz = 3;  // a hand that moves the camera round the object in 42 s
constexpr std::uint64_t kEarly = 30;
constexpr seconds kPatience{300};

/// Whatever is sharp is a keyframe, also where the camera comes by again.
RigRecording recorded(const fs::path& folder) {
  SimulationOptions options;  // the glossy teapot
  options.frames = kFrames;
  RigRecording rig = cached_recording(options, folder).recording;
  std::ofstream(folder / "every_sharp.toml")
      << std::ifstream(folder / "rig.toml").rdbuf() << "\n[gate]\nmin_angle_deg = 0.0\nmin_distance_m = 0.0\n";
  return rig;
}

double diagonal_mm(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  return 1e3 * box.diagonal().norm();
}

/// The largest of what was read while there were so many captures.
struct Peak {
  std::uint64_t from, to;
  double value = 0;
  void take(std::uint64_t captures, double read) {
    if (captures >= from && captures <= to) value = std::max(value, read);
  }
};

struct LiveCapture {
  std::uint64_t captures = 0;
  double processor_s = 0;     ///< of `serve`, until no more captures came
  double first_shape_of = 0;  ///< images
  std::uint64_t first_shape_at = 0, early_shape_at = 0;
  std::optional<Mesh> early_shape;  ///< as it was when there were `kEarly` captures
  Peak memory_60_mb{60, 120}, memory_600_mb{540, 600};
};

/// Of the first shape that `serve` logs.
double images_of_first_shape(const std::string& log) {
  constexpr const char* kField = " views=";
  const std::size_t found = log.find("found in the images so far"), at = log.find(kField, found);
  return found == std::string::npos || at == std::string::npos ? HUGE_VAL
                                                               : std::stod(log.substr(at + std::strlen(kField)));
}

/// `serve` with these options receives so many frames of the rig's camera. `finished`: the model is made, too.
LiveCapture captured(const RigRecording& rig, int frames, bool finished, const fs::path& folder, const Words& options) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  const fs::path session = folder / "session", shape = session / "shape.ply";
  const std::string endpoint = testing::free_address();
  Process camera(testing::tracker({"simulate", "--serve", rig.folder, "--rate", std::to_string(kRate_hz), "--loop"}));
  if (!camera.prints("serves", kPatience)) throw Error("the camera does not start:\n" + camera.output());
  Process desk(testing::reconstructor(Words{"serve", "--session", session, "--endpoint", endpoint, "--headless",
                                            "--once", "--no-monitor", "--json", folder / "report.json"} +
                                      options));
  Process tracker(testing::tracker({"run", "--config", rig.folder / "every_sharp.toml", "--endpoint", endpoint,
                                    "--frames", std::to_string(frames)}));
  LiveCapture live;
  const auto watch_until = [&](const std::string& what, const std::function<bool()>& happened) {
    for (const auto begin = Clock::now(); !happened(); std::this_thread::sleep_for(std::chrono::milliseconds(50))) {
      if (!desk.running() || Clock::now() - begin > kPatience + seconds(static_cast<int>(frames / kRate_hz)))
        throw Error("waited in vain for " + what + ":\n" + desk.output());
      live.captures = testing::captures_so_far(session);
      const double memory_mb = resident_mb(desk.id());
      live.memory_60_mb.take(live.captures, memory_mb);
      live.memory_600_mb.take(live.captures, memory_mb);
      if (!live.first_shape_at && fs::exists(shape)) live.first_shape_at = live.captures;
      if (live.captures >= kEarly && !live.early_shape && fs::exists(shape)) {
        live.early_shape_at = live.captures;
        live.early_shape = load_mesh(shape).mesh;
      }
    }
  };
  watch_until("the capture's end", [&] { return desk.output().find("finishing") != std::string::npos; });
  live.processor_s = processor_seconds(desk.id());
  live.first_shape_of = images_of_first_shape(desk.output());
  if (!finished) return live;
  if (const auto end = desk.wait(kPatience); !end || end->status != 0) throw Error("serve failed:\n" + desk.output());
  return live;
}

/// On the true mesh's pixels, of the images that it never saw.
double score_db(const fs::path& folder, const RigRecording& rig) {
  const ReconstructorRuns judge(folder / "session", folder);
  return judge.scores(folder / "session/model", rig.mesh_file()).psnr_db;
}

}  // namespace

void measure_live_shape(GoalReport& report, const fs::path& folder) {
  const RigRecording rig = recorded(folder / "live_rig");
  const fs::path with = folder / "live_with_mesh", without = folder / "live_without_mesh";
  const LiveCapture given = captured(rig, kFrames, true, with, {"--mesh", rig.mesh_file()}),
                    found = captured(rig, kFrames, true, without, {}),
                    many = captured(rig, kManyFrames, false, folder / "live_many", {});
  const auto beside_ms = [](const LiveCapture& shape, const LiveCapture& alone) {
    return 1e3 * (shape.processor_s / static_cast<double>(shape.captures) -
                  alone.processor_s / static_cast<double>(alone.captures));
  };
  const double light_field_ms = 1e3 * given.processor_s / static_cast<double>(given.captures);
  report.add(at_most(100, {}, "live: processor time per image beside the light field", beside_ms(found, given), "ms",
                     {{"of the light field, ms", light_field_ms},
                      {"of " + std::to_string(kManyFrames) + " frames, ms", beside_ms(many, given)}}));
  report.add(at_most(5, {}, "live: images that the first mesh is made of", found.first_shape_of, "",
                     {{"images that are there with it", found.first_shape_at}, {"images/s", kRate_hz}}));
  const Mesh truth = load_mesh(rig.mesh_file()).mesh;
  std::vector<PosedCamera> cameras;
  for (std::size_t i = 0; i < kEarly; ++i) cameras.push_back({rig.camera, rig.frames[i].camera_from_object});
  const Apart early = found.early_shape ? apart(truth, *found.early_shape, cameras) : Apart{HUGE_VAL, HUGE_VAL};
  report.add(at_most(1, {}, "live: true to found after 30 images, 90 %, of the diagonal",
                     100 * early.most_mm / diagonal_mm(truth), "%",
                     {{"mm", early.most_mm}, {"median, mm", early.median_mm}, {"images", found.early_shape_at}}));
  report.add(at_most(1.1, {}, "live: resident memory at 540 to 600 images over that at 60 to 120",
                     many.memory_600_mb.value / many.memory_60_mb.value, "ratio",
                     {{"MB at 60 to 120", many.memory_60_mb.value}}));
  const double on_true_db = score_db(with, rig), on_found_db = score_db(without, rig);
  report.add(at_least(-0.3, {}, "live: finished model over that on the true mesh", on_found_db - on_true_db, "dB",
                      {{"on the true mesh, dB", on_true_db}}));
}

}  // namespace sheen
