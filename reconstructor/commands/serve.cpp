// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "common/base/command_line.h"
#include "common/base/content_hash.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/log.h"
#include "common/base/repeated_work.h"
#include "common/base/report_file.h"
#include "common/base/service_manager.h"
#include "common/base/stop_signal.h"
#include "common/capture/rig_motion.h"
#include "common/link/endpoint.h"
#include "reconstructor/capture/capture_end.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/capture/capture_report.h"
#include "reconstructor/capture/live_display.h"
#include "reconstructor/capture/live_model.h"
#include "reconstructor/capture/live_refinement.h"
#include "reconstructor/capture/live_shape.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/capture/steered_capture.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/favour_option.h"
#include "reconstructor/commands/limit_options.h"
#include "reconstructor/commands/serve_end.h"
#include "reconstructor/commands/serve_wait.h"
#include "reconstructor/commands/serve_watch.h"
#include "reconstructor/commands/shape_finding.h"
#include "reconstructor/commands/size_options.h"
#include "reconstructor/effort/effort_control.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/monitor/monitor_server.h"
#include "reconstructor/monitor/monitor_token.h"
#include "reconstructor/render/gl/viewer_window.h"
#include "reconstructor/scene/model_choice.h"
#include "reconstructor/scene/scene_mesh.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kDisplayInterval{200};
constexpr std::chrono::milliseconds kMonitorInterval{1000};
constexpr const char* kMeshHashKey = "mesh_hash";
constexpr const char* kNoMesh = "none";

struct ServeArguments {
  std::string mesh, from_mesh, session, config, model, keys, json;
  std::vector<std::string> endpoints{ReceiverOptions{}.endpoint}, tracker_keys;
  std::string monitor_host = MonitorOptions{}.host, monitor_token_file, steer_token_file;
  int monitor_port = MonitorOptions{}.port;
  FavourArgument favour;
  LimitArguments limits;
  SizeArguments size;
  bool headless = false, once = false, no_monitor = false, refine = false;
};

/// A session belongs to one mesh, if any: with another one its captures would make nonsense.
Session open_session(const std::filesystem::path& folder, const std::string& mesh) {
  const std::string hash = mesh.empty() ? kNoMesh : content_hash(read_file(mesh));
  if (!Session::exists(folder)) {
    Session session = Session::create(folder);
    session.set_metadata(kMeshHashKey, hash);
    return session;
  }
  Session session = Session::open(folder);
  if (const auto known = session.metadata(kMeshHashKey); known && *known != hash)
    throw ConfigError(folder.string() + " was started " +
                      (*known == kNoMesh
                           ? "without a mesh; leave out --mesh"
                           : "with another mesh than " + (mesh.empty() ? "none" : mesh) + "; give that mesh") +
                      ", or a new --session folder");
  session.set_metadata(kMeshHashKey, hash);
  return session;
}

/// A link to each tracker.
std::vector<ReceiverOptions> link_options(const ServeArguments& arguments) {
  const std::size_t trackers = arguments.endpoints.size(), keys = arguments.tracker_keys.size();
  if (arguments.keys.empty() != arguments.tracker_keys.empty())
    throw ConfigError("--keys and --tracker-key go together: your own secret key and the public key of the tracker");
  if (keys > 1 && keys != trackers)
    throw ConfigError("--tracker-key: " + std::to_string(keys) + " keys for " + std::to_string(trackers) +
                      " trackers; give one for all of them, or one for each --endpoint in their order");
  std::optional<CurveKeys> own;
  if (!arguments.keys.empty()) own = load_keys(arguments.keys);
  std::vector<ReceiverOptions> links(trackers);
  for (std::size_t i = 0; i < trackers; ++i) {
    links[i].endpoint = arguments.endpoints[i];
    links[i].keys = own;
    if (own) links[i].server_public_key = load_public_key(arguments.tracker_keys[keys == 1 ? 0 : i]);
  }
  return links;
}

/// What starts a tracker that this reconstructor finds.
std::string tracker_command(const ReceiverOptions& link) {
  std::string command = "sheen-tracker run --config rig.toml";
  if (link.endpoint != ReceiverOptions{}.endpoint) command += " --endpoint " + link.endpoint;
  if (link.keys) command += " --keys tracker.key --allow allowed.txt";
  return command;
}

/// What keeps window and status page informed, when it is called again and again.
std::function<void()> publishing(const CaptureLoop& loop, const CaptureEnd& end, LiveDisplay& display,
                                 const SteeredCapture& steered, MonitorServer* monitor, bool window) {
  return [&loop, &end, &display, &steered, monitor, window,
          last_monitor = std::chrono::steady_clock::now() - kMonitorInterval,
          last_stage = EndStage::kCapturing]() mutable {
    const EndProgress progress = end.progress();
    const LoopStatus status = loop.status();
    if (window) display.publish_to_window(status, progress);
    const auto now = std::chrono::steady_clock::now();
    if (!monitor || (now - last_monitor < kMonitorInterval && progress.stage == last_stage)) return;
    last_monitor = now;
    last_stage = progress.stage;
    MonitorState state = display.monitor_state(status, progress);
    if (const std::vector<std::string> lines = steered.lines(); !lines.empty()) state.steering = lines.back();
    monitor->publish(std::move(state));
  };
}

/// What would build the model of the session's captures later.
std::string build_command(const ServeArguments& arguments) {
  std::string command = "sheen-reconstructor build " + arguments.session;
  if (!arguments.mesh.empty()) command += " --mesh " + arguments.mesh;
  if (!arguments.config.empty()) command += " --config " + arguments.config;
  if (!arguments.model.empty()) command += " --model " + arguments.model;
  return command + " --out " + arguments.session + "/" + kSessionModel;
}

/// What is to be modelled, and within which limits.
struct Plan {
  SceneConfig scene;
  Limits limits;
  std::optional<CompressionTarget> size;
};

Plan plan_for(ServeArguments arguments, SceneConfig scene) {
  Plan plan{std::move(scene), {}, {}};
  ModelSettings& settings = *plan.scene.settings;
  arguments.favour.fill(arguments.limits, arguments.size, settings);
  plan.limits = arguments.limits.apply(settings);
  plan.limits.favour = arguments.favour.word;
  if (arguments.limits.between_lights(settings))
    throw ConfigError("--tolerance: only `build` judges the lights of such a model");
  // Which maps and terms reach a PSNR shows when all images are there, or was measured: until then all that the target
  // needs is kept.
  if (plan.limits.psnr_db && plan.scene.measured.empty()) {
    if (!arguments.limits.tolerance.empty())
      throw ConfigError("--target and --tolerance exclude each other: the target sets the tolerance");
    set(settings, "tolerance", tolerance_of(*plan.limits.psnr_db));
  }
  plan.size = arguments.size.target(*plan.scene.kind, *plan.scene.settings);
  const std::filesystem::path model = std::filesystem::path(arguments.session) / kSessionModel;
  if (std::filesystem::exists(model)) check_model_path(model, plan.size.has_value());
  return plan;
}

/// `cameras`: the first image's, where there is one already.
std::unique_ptr<Reconstruction> reconstruction_for(const ServeArguments& arguments, const Plan& plan,
                                                   std::span<const PosedCamera> cameras) {
  const EndOnStop starting("sheen-reconstructor: stopped before the capture began");
  const ModelSettings& settings = *plan.scene.settings;
  Mesh mesh = surface_for(settings, arguments.mesh, cameras);
  require_no_origin(arguments.mesh.empty() ? "the first image's camera" : arguments.mesh, mesh);
  return std::make_unique<Reconstruction>(std::move(mesh), settings);
}

/// Looks at the shape: soon, and often, for each costs less than the images that came since.
LiveMeshOptions shape_options(int hold_out_every, std::uint64_t captures) {
  constexpr double kGrowth = 1.6;
  return {.name = "shape",
          .hold_out_every = hold_out_every,
          .fewest_images = 5,
          .first = static_cast<std::uint64_t>(kGrowth * static_cast<double>(captures)),
          .growth = kGrowth,
          .growth_at_end = 1};  // the last is finer
}

void open_monitor(std::optional<MonitorServer>& monitor, SteeredCapture& steered, LiveModel& model,
                  const ServeArguments& arguments) {
  if (arguments.no_monitor) return;
  monitor.emplace(
      MonitorOptions{.host = arguments.monitor_host,
                     .port = arguments.monitor_port,
                     .token = monitor_token(arguments.monitor_token_file),
                     .steer_token = arguments.steer_token_file.empty() ? "" : monitor_token(arguments.steer_token_file),
                     .steer = [&steered](const SteerRequest& request) { return steered.ask(request); },
                     .model = &model});
  log_info("monitor", "watch at " + monitor->url());
}

LiveDisplay::Names names_of(const ServeArguments& arguments, std::span<const ReceiverOptions> trackers) {
  LiveDisplay::Names names{.session_folder = arguments.session,
                           .trackers = {},
                           .model = "",
                           .model_reason = "",
                           .encrypted = !arguments.keys.empty()};
  for (const ReceiverOptions& tracker : trackers)
    names.trackers.push_back({tracker.endpoint, tracker_command(tracker)});
  return names;
}

/// Said when it is so: from then on a stop signal finishes the model.
void tell_it_waits(const LiveDisplay::Names& names) {
  for (const LiveDisplay::Names::Tracker& tracker : names.trackers)
    log_info("link", "waiting for a tracker", {{"endpoint", tracker.endpoint}, {"start", tracker.command}});
  tell_service_is_ready();
}

/// The model that fits what the first captures show to move.
Plan chosen_plan(ServeArguments& arguments, const SceneRequest& request, const RigMotion& motion,
                 LiveDisplay::Names& names) {
  Plan plan = plan_for(arguments, request.chosen_by(motion));
  names.model = plan.scene.kind->name();
  names.model_reason = in_words(motion);
  log_info("model", "chosen: " + names.model + ", because " + names.model_reason);
  if (!arguments.mesh.empty() && surface_needs_camera(*plan.scene.settings, arguments.mesh)) {
    log_info("model", "it makes its own surface: the mesh is not used", {{"mesh", arguments.mesh}});
    arguments.mesh.clear();
  }
  return plan;
}

/// Says how the capture went and writes the report.
void report_end(const ServeArguments& arguments, const CaptureEnd::Result& result, const LoopStatus& status,
                nlohmann::json model_choice, std::vector<std::string> steering, ReportFile& json) {
  if (result.model)
    log_info("session", "the model is saved", {{"model", result.model->string()}, {"captures", status.journaled}});
  else
    log_info("session", "no model: no image was accepted",
             {{"folder", arguments.session}, {"captures", status.journaled}});
  nlohmann::json report = *result.report;
  if (!model_choice.is_null()) report["model_choice"] = std::move(model_choice);
  if (!steering.empty()) report["steering"] = std::move(steering);
  print_summary(report);
  if (const std::string failure = status.link().source_failure; !failure.empty())
    log_warning("link", "the source failed: " + failure);
  json.write(to_text(report));
}

FileError none_was_usable(const ServeArguments& arguments, std::uint64_t ingested, bool makes_own_surface) {
  const std::string captures = std::to_string(ingested);
  return makes_own_surface
             ? FileError(arguments.session,
                         "none of its " + captures +
                             " captures can be used; they are kept; a model of moving light needs a light "
                             "in each")
             : FileError(arguments.mesh.empty() ? arguments.session + "/" + kShapeFile : arguments.mesh,
                         "none of the session's " + captures +
                             " captures shows this mesh; they are kept; check that mesh and stage are in the "
                             "same frame and units");
}

void serve(ServeArguments arguments) {
  install_stop_signals();
  std::signal(SIGPIPE, SIG_IGN);  // the reader of our messages may be gone before the model is saved
  ReportFile json(arguments.json);
  const SceneRequest request(arguments.config, arguments.model);
  std::vector<ReceiverOptions> trackers = link_options(arguments);
  std::optional<Plan> plan;
  if (!request.automatic()) plan = plan_for(arguments, request.named());
  if (arguments.refine && plan && surface_needs_camera(*plan->scene.settings, arguments.mesh))
    throw ConfigError(std::string("--refine: ") + plan->scene.kind->name() + " has no mesh to refine; leave it out");
  if (arguments.refine && plan && arguments.mesh.empty())
    throw ConfigError(
        "--refine corrects a mesh that is given; a shape that is found in the images becomes better by itself");
  if (!arguments.from_mesh.empty() && plan && plan->scene.settings->makes_mesh())
    throw ConfigError(std::string("--from-mesh: ") + plan->scene.kind->name() + " looks for no shape; leave it out");
  std::shared_ptr<const Mesh> rough;
  if (std::optional<Mesh> mesh = rough_mesh(arguments.from_mesh))
    rough = std::make_shared<const Mesh>(*std::move(mesh));
  const bool waits = !plan || arguments.mesh.empty();
  std::unique_ptr<Reconstruction> reconstructed = waits ? nullptr : reconstruction_for(arguments, *plan, {});

  LiveDisplay::Names names = names_of(arguments, trackers);
  if (plan) names.model = plan->scene.kind->name();
  SteeredCapture steered;
  LiveModel live_model;
  std::optional<MonitorServer> monitor;
  open_monitor(monitor, steered, live_model, arguments);
  std::optional<ViewerWindow> screen;
  if (!arguments.headless && plan) open_window(screen, *plan->scene.kind, {.screenshot_folder = arguments.session});
  if (!arguments.headless && !plan) require_display();
  ViewerWindow* window = screen ? &*screen : nullptr;

  Session session = open_session(arguments.session, arguments.mesh);  // not before all else is there that it needs
  if (session.size() > 0) log_info("session", "resumed", {{"captures", session.size()}});
  for (ReceiverOptions& tracker : trackers) tracker.held = session.held();
  auto links = std::make_unique<TrackerLinks>(trackers);
  LinkLog link_log;
  std::shared_ptr<const Mesh> shape;  // that was found, where no mesh was given and the model makes none
  if (waits) {
    tell_it_waits(names);
    const CaptureToBegin beginning{
        arguments.session, session, *links, arguments.once, names, link_log, monitor ? &*monitor : nullptr, window};
    const std::optional<FirstCapture::Found> first = wait_for_first(beginning);
    if (!first) return log_info("session", "ended before the capture began", {{"folder", arguments.session}});
    if (!plan) {
      plan = chosen_plan(arguments, request, first->motion, names);
      if (!arguments.headless) open_window(screen, *plan->scene.kind, {.screenshot_folder = arguments.session});
      window = screen ? &*screen : nullptr;
    }
    const ModelSettings& settings = *plan->scene.settings;
    if (arguments.mesh.empty() && !settings.makes_mesh()) {
      shape = wait_for_shape(beginning, settings.hold_out_every, rough);
      if (!shape) return log_info("session", "ended before there was a shape", {{"folder", arguments.session}});
      if (arguments.refine)  // the model was chosen only now
        log_warning("mesh", "--refine is not used: the shape that is found in the images becomes better by itself");
      reconstructed = std::make_unique<Reconstruction>(*shape, settings);
    } else {
      const Capture& capture = first->capture;
      reconstructed = reconstruction_for(arguments, *plan, {{{capture.camera, capture.pose.camera_from_object}}});
    }
  }
  Reconstruction& reconstruction = *reconstructed;
  reconstruction.keep_within(plan->limits, session.metadata(kEffortKey).value_or(""), session.size(),
                             plan->scene.measured);
  const std::shared_ptr<const Mesh> given = reconstruction.shared_mesh();
  LiveDisplay display(names);
  LoopObserver observer = display.observer();
  live_model.watch(*plan->scene.kind, observer);
  if (!arguments.mesh.empty()) watch_mesh(*given, display, observer);
  observer.on_link = [&link_log](const std::vector<LinkState>& states) { link_log.look(states); };
  const bool refines = arguments.refine && !arguments.mesh.empty();
  const std::shared_ptr<const Mesh> present = refines ? refined_mesh_of(arguments.session, *given) : nullptr;
  if (present) reconstruction.restart_on(present);
  observer.on_snapshot(reconstruction.snapshot(), reconstruction.shared_painter());  // the mesh, before any image
  watch_motion(*plan->scene.kind, display, observer);
  CaptureLoop loop(arguments.session, std::move(session), std::move(links), reconstruction,
                   {.stop_when_source_ends = arguments.once, .awaits_last_mesh = refines || shape},
                   std::move(observer));
  std::optional<LiveMesh> live_mesh;
  const int hold_out = plan->scene.settings->hold_out_every;
  const auto no_more = [&loop] { return loop.status().no_more_captures; };
  if (refines)
    live_mesh.emplace(
        loop, arguments.session, LiveMeshOptions{.hold_out_every = hold_out},
        refining_look(arguments.session, given, present ? present : given, no_more, tells_findings(display)));
  if (shape)
    live_mesh.emplace(loop, arguments.session, shape_options(hold_out, loop.status().journaled),
                      shape_look(arguments.session, rough, no_more, tells_findings(display)));
  CaptureEnd end(loop, reconstruction, arguments.session, plan->size, live_mesh ? &*live_mesh : nullptr);
  if (stop_requested()) return log_info("session", "ended before the capture began", {{"folder", arguments.session}});
  install_stop_signals(2);  // the first begins the end, the second cuts it short
  loop.start();
  if (live_mesh) live_mesh->start();
  if (!waits) tell_it_waits(names);
  const RepeatedWork publisher(
      "display", kDisplayInterval,
      publishing(loop, end, display, steered, monitor ? &*monitor : nullptr, window != nullptr));
  const auto over = [&] {
    steered.carry_out(loop);
    return loop.finished() || loop.status().no_more_captures || stop_requested() || steered.finishes();
  };
  wait_until(
      over, window, display.feed(),
      {.take_back = [&loop] { return take_back_last(loop); }, .hold_out = [&loop] { return hold_out_next(loop); }});
  tell_service_is_stopping();
  const CaptureEnd::Result result =
      end_capture(loop, end, window, display.feed(), {arguments.session, build_command(arguments)});
  nlohmann::json model_choice;
  if (request.automatic()) model_choice = {{"model", names.model}, {"why", names.model_reason}};
  const LoopStatus status = loop.status();
  report_end(arguments, result, status, std::move(model_choice), steered.lines(), json);
  const auto& counts = reconstruction.account().counts();
  if (status.ingested > status.counts.withdrawn && counts.accepted + counts.held_out == 0)
    throw none_was_usable(arguments, status.ingested, surface_needs_camera(*plan->scene.settings, arguments.mesh));
}

}  // namespace

void add_serve_command(Command& program) {
  auto a = std::make_shared<ServeArguments>();
  Command command =
      program.subcommand("serve", "Receives images from a tracker, stores them, and adds them to the model.");
  const Option mesh = command.option(
      "--mesh", a->mesh,
      "PLY, OBJ or OFF of the object, in the stage's frame; without one the shape is found in the images");
  add_rough_mesh_option(command, a->from_mesh).excludes({mesh});
  command.option("--session", a->session, "folder of the session; continued if it exists").required();
  const Option config = command.option("--config", a->config, "scene file (TOML)");
  command
      .option("--model", a->model,
              "kind of model, without a scene file: " + names_of_kinds() +
                  "; or auto: by what moves, camera or light or both, as the tracker announces it")
      .excludes({config});
  command.flag("--refine", a->refine, "correct the mesh against the images as they come, as `refine` does");
  a->favour.add_to(command);
  a->limits.add_to(command,
                   "PSNR that held-out views must reach, such as 35dB; no patch is kept more exactly than that");
  a->size.add_to(command);
  command.option("--endpoint", a->endpoints, "endpoint of the tracker; once for each of several")
      .check({endpoint_error})
      .one_each_time()
      .show_default();
  command.option("--keys", a->keys, "own secret key (NAME.key); encrypts the link");
  command
      .option("--tracker-key", a->tracker_keys,
              "the tracker's public key (NAME.pub); of several one for all, or one for each --endpoint")
      .one_each_time();
  command.flag("--headless", a->headless, "no window");
  command.flag("--once", a->once, "end when the source has ended and everything is in the model");
  command.flag("--no-monitor", a->no_monitor, "no status page");
  command.option("--monitor-host", a->monitor_host, "address of the status page").show_default();
  command.option("--monitor-port", a->monitor_port, "port of the status page; 0 = any free one")
      .check(range(0, 65535))
      .show_default();
  command.option(
      "--monitor-token-file", a->monitor_token_file,
      "file (mode 600) with the token that the page asks for; needed when other machines can reach the page; or "
      "set SHEEN_MONITOR_TOKEN");
  command.option(
      "--steer-token-file", a->steer_token_file,
      "file (mode 600) with the token of those who may steer from the page: take back, hold out, note, finish");
  command.option("--json", a->json, "report to write at the end; - for standard output");
  command.callback([a] { serve(*a); });
}

}  // namespace sheen
