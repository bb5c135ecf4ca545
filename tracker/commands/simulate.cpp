// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <future>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <thread>
#include <tuple>
#include <utility>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/base/order_statistics.h"
#include "common/base/progress.h"
#include "common/base/quantity.h"
#include "common/base/stop_signal.h"
#include "common/session/session.h"
#include "common/simulation/light_rig.h"
#include "common/simulation/pose_truth.h"
#include "common/simulation/simulated_rig.h"
#include "tracker/camera_server/camera_server.h"
#include "tracker/commands/commands.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kPoll{50};

struct SimulateArguments {
  std::filesystem::path out, serve, log, judge, recording;
  CameraServerOptions server;
  SimulationOptions rig;
  std::string size = "1024x768", views = "5x5";
  int lights = 0;
  double gloss = 0;
  bool json = false;
};

std::pair<int, int> size_of(const SimulateArguments& arguments) {
  const auto [width, height] = parse_image_size("--size", arguments.size, 16);
  return {width, height};
}

void render(SimulateArguments arguments) {
  const EndOnStop give_up("sheen-tracker: stopped; what is rendered is kept, the same command renders the rest");
  std::tie(arguments.rig.width, arguments.rig.height) = size_of(arguments);
  const auto start = std::chrono::steady_clock::now();
  const CachedRecording result = [&] {
    Progress progress("rendering", static_cast<std::uint64_t>(std::max(0, arguments.rig.frames)));
    return cached_recording(arguments.rig, arguments.out, [&](int done, int) {
      if (stop_requested()) throw Error("stopped; the recording is incomplete and will be rendered again");
      progress.update(static_cast<std::uint64_t>(done));
    });
  }();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto frames = result.recording.frames.size();
  if (arguments.json) {
    std::cout << nlohmann::json{{"folder", arguments.out.string()},
                                {"frames", frames},
                                {"rendered", result.rendered},
                                {"seconds", seconds},
                                {"seconds_per_frame", result.rendered ? seconds / double(frames) : 0.0}}
                     .dump(2)
              << '\n';
  } else if (result.rendered) {
    std::printf("%zu frames rendered into %s in %.0f s\n", frames, arguments.out.c_str(), seconds);
  } else {
    std::printf("%s already holds these %zu frames\n", arguments.out.c_str(), frames);
  }
}

/// Several lamps and a grid of cameras in place of the stage.
void render_lights(const SimulateArguments& arguments) {
  const EndOnStop give_up("sheen-tracker: stopped; the data set is incomplete");
  LightRigOptions options{.lights = arguments.lights, .gloss = arguments.gloss};
  std::tie(options.width, options.height) = size_of(arguments);
  int used = 0;
  if (std::sscanf(arguments.views.c_str(), "%3dx%3d%n", &options.columns, &options.rows, &used) != 2 ||
      used != int(arguments.views.size()))
    throw ConfigError("--views \"" + arguments.views + "\" is not a grid; write it as 5x5");
  const LightRig rig(options);
  int images = 0;
  {
    Progress progress("rendering", 0);
    write_light_rig(rig, arguments.out, arguments.rig.truth, [&](int done, int total) {
      if (stop_requested()) throw Error("stopped; the data set is incomplete");
      images = total;
      progress.update(static_cast<std::uint64_t>(done));
    });
  }
  if (arguments.json)
    std::cout << nlohmann::json{{"folder", arguments.out.string()}, {"images", images}}.dump(2) << '\n';
  else
    std::printf("%d images in %d lights rendered into %s\n", images, arguments.lights, arguments.out.c_str());
}

/// Serves a recording as a camera until it is told to stop; the log names each frame as it is sent. `ready`: how many
/// frames there are by now; it may throw.
void serve(const RigRecording& recording, const SimulateArguments& arguments,
           const std::function<std::size_t()>& ready) {
  CameraServer server(recording, arguments.server, ready());
  std::ofstream log;
  if (!arguments.log.empty()) {
    log.open(arguments.log);
    if (!log) throw FileError(arguments.log.string(), "cannot be written");
  }
  std::cerr << "sheen-tracker: aravis:" << arguments.server.address << " serves " << arguments.serve.string() << '\n';
  while (!stop_requested()) {
    std::this_thread::sleep_for(kPoll);
    server.load_until(ready());
    for (const SentFrame& frame : server.take_sent()) log << frame.camera_frame_id << ',' << frame.rig_index << '\n';
    log.flush();
    if (!arguments.log.empty() && !log) throw FileError(arguments.log.string(), "cannot be written");
  }
}

void serve(const RigRecording& recording, const SimulateArguments& arguments) {
  serve(recording, arguments, [&] { return recording.frames.size(); });
}

/// From the first frame on, while the others are rendered.
void serve_while_rendering(SimulateArguments arguments) {
  if (arguments.out != arguments.serve)
    throw ConfigError("--out with --serve serves what is rendered: give both the same folder");
  std::tie(arguments.rig.width, arguments.rig.height) = size_of(arguments);
  if (const auto finished = finished_recording(arguments.rig, arguments.out)) return serve(*finished, arguments);
  const EndOnStop give_up("sheen-tracker: stopped; the recording is incomplete and will be rendered again");
  const SimulatedRig rig(arguments.rig);
  std::atomic<std::size_t> rendered = 0;
  std::promise<void> end;
  std::future<void> ended = end.get_future();
  const std::jthread renderer = guarded_thread(
      [&](const std::stop_token& given_up) {
        write_recording(rig, arguments.out, [&](int done, int) {
          if (stop_requested() || given_up.stop_requested())
            throw Error("stopped; the recording is incomplete and will be rendered again");
          rendered = std::size_t(done);
        });
      },
      [&](const std::exception_ptr& error) { end.set_exception(error); });
  const auto ready = [&] {
    if (ended.wait_for(std::chrono::seconds(0)) == std::future_status::ready) ended.get();  // it failed: throws
    return rendered.load();
  };
  while (ready() == 0) std::this_thread::sleep_for(kPoll);
  serve(planned_recording(rig, arguments.out), arguments, ready);
}

/// How far the poses of a session are from the truth of the recording that was served.
void judge(const SimulateArguments& arguments) {
  if (arguments.recording.empty() || arguments.log.empty())
    throw ConfigError("--judge SESSION needs --recording DIR and the --log FILE that --serve wrote");
  const RigRecording recording = load_rig_recording(arguments.recording);
  const SentFrames sent = read_sent_frames(arguments.log);
  const Session session = Session::open_read_only(arguments.judge);
  PoseErrors errors;
  for (std::uint64_t i = 0; i < session.size(); ++i) add_pose_error(session.read(i), recording, sent, errors);
  const auto at = [](double q, const std::vector<double>& of) {
    return of.empty() ? std::numeric_limits<double>::quiet_NaN() : quantile(of, q);
  };
  const nlohmann::json report{{"captures", errors.centre_mm.size()},
                              {"unmatched", errors.unmatched},
                              {"centre_mm_p50", at(0.50, errors.centre_mm)},
                              {"centre_mm_p95", at(0.95, errors.centre_mm)},
                              {"rotation_deg_p95", at(0.95, errors.rotation_deg)}};
  std::cout << report.dump(2) << '\n';
}

void simulate(const SimulateArguments& arguments) {
  if (arguments.out.empty() && arguments.serve.empty() && arguments.judge.empty())
    throw ConfigError("give --out DIR to render a recording, --serve DIR to serve one as a camera, or --judge SESSION");
  if (!arguments.judge.empty()) return judge(arguments);
  if (arguments.lights > 0 && (arguments.out.empty() || !arguments.serve.empty()))
    throw ConfigError("--lights renders a data set: give --out DIR, and no --serve");
  if (arguments.lights > 0) return render_lights(arguments);
  if (arguments.serve.empty()) return render(arguments);
  if (arguments.out.empty()) return serve(load_rig_recording(arguments.serve), arguments);
  serve_while_rendering(arguments);
}

}  // namespace

void add_simulate_command(Command& program) {
  Command command = program.subcommand(
      "simulate", "Renders a simulated rig, an object on a stage with tags, and serves it as a camera.");
  const auto arguments = std::make_shared<SimulateArguments>();
  command.option("--out", arguments->out,
                 "folder of the recording; nothing is rendered when it holds the same one already");
  command.option("--frames", arguments->rig.frames, "number of frames")
      .check(whole_number_in(1, 1'000'000))
      .show_default();
  command.option("--size", arguments->size, "size of a frame, WIDTHxHEIGHT in pixels").show_default();
  command.option("--seed", arguments->rig.seed, "seed of the camera's path and of the noise")
      .check(whole_number_in(0, std::numeric_limits<std::uint32_t>::max()))
      .show_default();
  command.option("--object", arguments->rig.object, "demo, bronze, lacquer or sphere").show_default();
  command.option("--light-path", arguments->rig.light_path,
                 "a lamp moves in the dimmed studio: dome, plane, or positions of a list of lights (FILE.lp)");
  command.flag("--still-camera", arguments->rig.still_camera, "the camera does not move");
  command.flag("--truth", arguments->rig.truth, "also write each frame's linear radiance as OpenEXR");
  command
      .option("--lights", arguments->lights,
              "a still life in so many lights, seen by a grid of cameras, in place of the rig; with --truth also "
              "depth, reflectance and shadows")
      .check(whole_number_in(2, 99));
  command.option("--views", arguments->views, "with --lights: the grid of cameras, COLUMNSxROWS").show_default();
  command.option("--gloss", arguments->gloss, "with --lights: how glossy ball, rod, cone and disc are")
      .check(number_in(0, 1))
      .show_default();
  command.option("--serve", arguments->serve,
                 "recording to serve as a GigE Vision camera, until Ctrl-C; that of --out while it is rendered");
  command.option("--interface", arguments->server.address, "loopback address to serve on").show_default();
  command.option("--rate", arguments->server.frame_rate_hz, "frames/s to serve; default: those of the recording")
      .check(number_in(0.001, 10000));
  command.flag("--loop", arguments->server.loop,
               "start again after the last frame; without it the last frame is repeated");
  command.option("--log", arguments->log, "write frame_id,rig_index for each frame sent; read by --judge");
  command.option("--judge", arguments->judge, "session whose poses are compared with the truth (JSON)");
  command.option("--recording", arguments->recording, "with --judge: the recording that was served");
  command.flag("--json", arguments->json, "print JSON");
  command.callback([arguments] { simulate(*arguments); });
}

}  // namespace sheen
