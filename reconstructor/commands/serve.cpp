// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "common/content_hash.h"
#include "common/errors.h"
#include "common/files.h"
#include "common/log.h"
#include "common/stop_signal.h"
#include "reconstructor/budget.h"
#include "reconstructor/capture_loop.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/wish_options.h"
#include "reconstructor/live_display.h"
#include "reconstructor/monitor/monitor_server.h"
#include "reconstructor/render/gl/viewer_window.h"
#include "reconstructor/report.h"
#include "reconstructor/saved_model.h"
#include "reconstructor/scene_config.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kDisplayInterval{200};
constexpr std::chrono::milliseconds kMonitorInterval{1000};
constexpr const char* kMeshHashKey = "mesh_hash";

struct ServeArguments {
  std::string mesh, session, config, endpoint = ReceiverOptions{}.endpoint, keys, tracker_key, json;
  std::string monitor_host = MonitorOptions{}.host, monitor_token;
  int monitor_port = MonitorOptions{}.port;
  WishArguments wish;
  bool headless = false, once = false, no_monitor = false;
};

/// A session belongs to one mesh: with another one its captures would make nonsense.
Session open_session(const std::filesystem::path& folder, const std::filesystem::path& mesh) {
  const std::string hash = content_hash(read_file(mesh));
  if (!Session::exists(folder)) {
    Session session = Session::create(folder);
    session.set_metadata(kMeshHashKey, hash);
    return session;
  }
  Session session = Session::open(folder);
  if (const auto known = session.metadata(kMeshHashKey); known && *known != hash)
    throw ConfigError(folder.string() + " was begun with another mesh than " + mesh.string() +
                      "; give that mesh, or a new --session folder");
  session.set_metadata(kMeshHashKey, hash);
  return session;
}

ReceiverOptions link_options(const ServeArguments& arguments) {
  ReceiverOptions link;
  link.endpoint = arguments.endpoint;
  if (arguments.keys.empty() != arguments.tracker_key.empty())
    throw ConfigError("--keys and --tracker-key go together: one's own secret key and the tracker's public one");
  if (!arguments.keys.empty()) {
    link.keys = load_keys(arguments.keys);
    link.server_public_key = load_public_key(arguments.tracker_key);
  }
  return link;
}

/// Without a display there is no window; without asking, there is no capture that nobody sees either.
void open_window(std::optional<ViewerWindow>& window, const std::filesystem::path& screenshot_folder) {
  try {
    window.emplace(ViewerOptions{.screenshot_folder = screenshot_folder});
  } catch (const DeviceError& error) {
    throw DeviceError(std::string(error.what()) + "; with --headless the capture goes without a window");
  }
}

/// Tells the log when the tracker comes and goes, and why it refuses.
class LinkLog {
 public:
  void look(const ReceiverStats& link) {
    if (link.connected != connected_) log_info("link", link.connected ? "connected to the tracker" : "tracker gone");
    if (!link.last_error.empty() && link.last_error != error_) log_warning("link", link.last_error);
    connected_ = link.connected;
    error_ = link.last_error;
  }

 private:
  bool connected_ = false;
  std::string error_;
};

/// What the person at the window is told.
std::string take_back_last(CaptureLoop& loop) {
  try {
    const std::optional<std::uint64_t> taken = loop.withdraw_last();
    return taken ? "image " + std::to_string(*taken) + " is taken back" : "there is no image to take back";
  } catch (const Error& error) {
    return std::string("not taken back: ") + error.what();
  }
}

/// A model that is about to be saved is first made anew without what was taken back; Ctrl-C waits for nothing.
void finish_withdrawals(CaptureLoop& loop) {
  if (stop_requested() || loop.status().exact) return;
  loop.stop_receiving();
  log_info("session", "the model is made anew without what was taken back");
  while (!stop_requested() && !loop.finished() && !loop.status().exact)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

/// Feeds the watchers until the loop has finished, the person closes the window or a signal asks to stop.
void watch(CaptureLoop& loop, LiveDisplay& display, MonitorServer* monitor, ViewerWindow* window) {
  std::stop_source done;
  std::jthread publisher([&](std::stop_token stop) {
    LinkLog link_log;
    auto last_monitor = std::chrono::steady_clock::now() - kMonitorInterval;
    while (!stop.stop_requested() && !loop.finished() && !stop_requested()) {
      const LoopStatus status = loop.status();
      link_log.look(status.link);
      if (window) display.publish_to_window(status);
      if (monitor && std::chrono::steady_clock::now() - last_monitor >= kMonitorInterval) {
        last_monitor = std::chrono::steady_clock::now();
        monitor->publish(display.monitor_state(status));
      }
      std::this_thread::sleep_for(kDisplayInterval);
    }
    done.request_stop();
  });
  if (window) {
    try {
      return window->run(display.feed(), done.get_token(), [&loop] { return take_back_last(loop); });
    } catch (const Error& error) {
      log_warning("window", "the capture goes on without it: " + std::string(error.what()));
    }
  }
  publisher.join();
}

nlohmann::json live_report(Reconstruction& reconstruction, const LoopStatus& status) {
  nlohmann::json report = reconstruction_report(reconstruction);
  report["frames"]["journaled"] = status.journaled;
  report["frames"]["duplicates"] = status.link.duplicates;
  report["frames"]["lost"] = status.journaled - status.ingested;
  const auto ms = [&](double q) { return 1e3 * status.latency.quantile_s(q); };
  if (status.latency.count() > 0) report["latency_ms"] = {{"p50", ms(0.50)}, {"p95", ms(0.95)}, {"p99", ms(0.99)}};
  return report;
}

void serve(const ServeArguments& arguments) {
  install_stop_signals();
  SceneConfig config = arguments.config.empty() ? SceneConfig{} : load_scene_config(arguments.config);
  const TradeoffWish wish = arguments.wish.apply(config.surface_light_field);
  // Which maps and terms reach a PSNR shows when all images are there: until then all that the target needs is kept.
  if (wish.psnr_db) {
    if (!arguments.wish.tolerance.empty())
      throw ConfigError("--target and --tolerance exclude each other: the target sets the tolerance");
    config.surface_light_field.ring.factor.tolerance = tolerance_of(*wish.psnr_db);
  }
  const ReceiverOptions link = link_options(arguments);
  Reconstruction reconstruction(load_mesh_and_warn(arguments.mesh), config.surface_light_field);
  Session session = open_session(arguments.session, arguments.mesh);
  reconstruction.keep_within(wish, session.metadata(kEffortKey).value_or(""), session.size());
  if (session.size() > 0) log_info("session", "resumed", {{"captures", session.size()}});

  LiveDisplay display(reconstruction.painter(), {arguments.session, link.endpoint, link.keys.has_value()});
  std::optional<MonitorServer> monitor;
  if (!arguments.no_monitor) {
    monitor.emplace(MonitorOptions{arguments.monitor_host, arguments.monitor_port, arguments.monitor_token});
    log_info("monitor", "watch at " + monitor->url());
  }
  std::optional<ViewerWindow> window;
  if (!arguments.headless) open_window(window, arguments.session);

  CaptureLoop loop(arguments.session, std::move(session), link, reconstruction,
                   {.stop_when_source_ends = arguments.once}, display.observer());
  loop.start();
  log_info("link", "waiting for a tracker", {{"endpoint", link.endpoint}});
  watch(loop, display, monitor ? &*monitor : nullptr, window ? &*window : nullptr);
  finish_withdrawals(loop);
  loop.stop();

  const LoopStatus status = loop.status();
  if (monitor) monitor->publish(display.monitor_state(status));
  if (!status.error.empty()) throw Error(status.error);
  if (stop_requested()) {  // whoever presses Ctrl-C waits for nothing: the journal has it all
    log_info("session", "kept; the same command goes on with it, `build` makes its model",
             {{"folder", arguments.session}, {"captures", status.journaled}});
    return;
  }
  if (reconstruction.counts().accepted > 0)
    save_reconstruction(reconstruction, std::filesystem::path(arguments.session) / "model", arguments.session);
  const nlohmann::json report = live_report(reconstruction, status);
  print_summary(report);
  if (!arguments.json.empty()) write_json(arguments.json, report);
  if (status.ingested > status.counts.withdrawn &&
      reconstruction.counts().accepted + reconstruction.counts().held_out == 0)
    throw FileError(arguments.mesh, "none of the session's " + std::to_string(status.ingested) +
                                        " captures shows this mesh; they are kept; check that mesh and stage are in "
                                        "the same frame and units");
}

}  // namespace

void add_serve_command(CLI::App& app) {
  auto a = std::make_shared<ServeArguments>();
  CLI::App* command = app.add_subcommand(
      "serve", "Receives captures from a tracker, keeps them, and grows the surface light field as they come.");
  command->add_option("--mesh", a->mesh, "PLY, OBJ or OFF of the object, in the stage's frame")->required();
  command->add_option("--session", a->session, "folder of the session; continued if it exists")->required();
  command->add_option("--config", a->config, "scene file (TOML)");
  a->wish.add_to(*command, "PSNR that held-out views are to reach: 35dB; no ring is kept more exactly than that");
  command->add_option("--endpoint", a->endpoint, "of the tracker")->capture_default_str();
  command->add_option("--keys", a->keys, "own secret key (NAME.key); encrypts the link");
  command->add_option("--tracker-key", a->tracker_key, "the tracker's public key (NAME.pub)");
  command->add_flag("--headless", a->headless, "no window");
  command->add_flag("--once", a->once, "end when the source has ended and everything is in the model");
  command->add_flag("--no-monitor", a->no_monitor, "no status page");
  command->add_option("--monitor-host", a->monitor_host, "address of the status page")->capture_default_str();
  command->add_option("--monitor-port", a->monitor_port, "port of the status page; 0 = any free one")
      ->capture_default_str();
  command->add_option("--monitor-token", a->monitor_token, "asked of everyone who watches; needed beyond loopback");
  command->add_option("--json", a->json, "report to write at the end; - for standard output");
  command->callback([a] { serve(*a); });
}

}  // namespace sheen
