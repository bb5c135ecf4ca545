// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <utility>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/report_file.h"
#include "common/base/service_manager.h"
#include "common/base/stop_signal.h"
#include "common/link/endpoint.h"
#include "common/link/monitor_socket.h"
#include "common/link/transport.h"
#include "tracker/commands/commands.h"
#include "tracker/commands/live_line.h"
#include "tracker/commands/logging.h"
#include "tracker/link_sink.h"
#include "tracker/open_rig.h"
#include "tracker/rig_config.h"
#include "tracker/rig_tracking.h"
#include "tracker/sources/stream_address.h"

namespace sheen {
namespace {

constexpr std::size_t kRetainedKeyframes = 256;  ///< a burst of some seconds that the reconstructor has yet to store
constexpr std::chrono::milliseconds kFinishStep{100};
constexpr double kHurriedLinger_s = 0.5;  ///< after Ctrl-C, for a desk that has acknowledged nothing
constexpr double kLongestPause_s = 6;     ///< between two acknowledgements; the link gives a silent desk up before

struct RunArguments {
  std::filesystem::path config, keys, allow, json;
  std::string source, endpoint, publish;
  std::uint64_t frames = 0;
  double linger_s = 30;
};

/// Command line over configuration file.
RigConfig configuration(const RunArguments& arguments) {
  RigConfig config = arguments.config.empty() ? RigConfig{} : load_rig_config(arguments.config);
  if (!arguments.source.empty()) {
    if (config.cameras.size() > 1)
      throw ConfigError("--source: " + arguments.config.string() + " has " + std::to_string(config.cameras.size()) +
                        " cameras, each with its own source");
    config.cameras.front().source_uri = arguments.source;
  }
  if (!arguments.endpoint.empty()) config.endpoint = arguments.endpoint;
  if (!arguments.keys.empty()) config.keys = arguments.keys;
  if (!arguments.allow.empty()) config.allow = arguments.allow;
  if (!config.cameras.front().source_uri)
    throw ConfigError("no source; give --source URI or a --config whose [source] has a uri");
  return config;
}

/// Names a run of a camera: the second it began in, the process, and a random number, for two machines may start at
/// once.
std::string new_session() {
  const std::time_t now = std::time(nullptr);
  char text[64];
  std::strftime(text, sizeof text, "live:%Y%m%dT%H%M%SZ:", std::gmtime(&now));
  return text + std::to_string(getpid()) + format(":%08x", std::random_device()());
}

/// Waits until everything is acknowledged: for `linger_s`, or, after Ctrl-C, while a desk that stores keyframes goes on
/// to acknowledge them. The next Ctrl-C ends the process.
void drain(CaptureSender& sender, double linger_s, const std::string& failure) {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  Clock::time_point since = Clock::now();
  std::uint64_t acknowledged = 0;
  bool hurried = false, told = false;
  while (!sender.finish(kFinishStep, failure)) {
    const SenderStats now = sender.stats();
    if (stop_requested() && (!hurried || now.acknowledged > acknowledged)) {
      hurried = true;
      acknowledged = now.acknowledged;
      since = Clock::now();
    }
    const bool stored = now.acknowledged > 0 && now.acknowledged < now.kept;
    const Seconds waited = Clock::now() - since;
    if (waited > Seconds(!hurried ? linger_s : stored ? kLongestPause_s : kHurriedLinger_s)) return;
    if (hurried && stored && waited > Seconds(kHurriedLinger_s) && !std::exchange(told, true))
      std::cerr << "sheen-tracker: waits for the reconstructor to store " << now.kept - now.acknowledged
                << " keyframes; Ctrl-C again gives them up\n";
  }
}

/// How many keyframes are on no disk, and how they get there.
std::string undelivered_text(std::uint64_t keyframes, const std::string& endpoint, const SenderStats& sent,
                             bool can_be_repeated) {
  const std::string refusal = sent.last_refusal.empty() ? "" : " (last refusal: " + sent.last_refusal + ")";
  return std::to_string(keyframes) + " keyframes were not acknowledged" + refusal +
         "; start `sheen-reconstructor serve --endpoint " + endpoint + "` and run this command again" +
         (can_be_repeated ? ": what is already on the disk of the reconstructor is not sent again"
                          : ": these are lost, take the images again (--linger waits longer at the end)");
}

std::map<std::string, std::uint64_t> link_counters(const SenderStats& s) {
  return {{"kept", s.kept},
          {"delivered", s.delivered},
          {"acknowledged", s.acknowledged},
          {"resent", s.resent},
          {"live_sent", s.live_sent},
          {"live_dropped", s.live_dropped},
          {"rejected_messages", s.rejected_messages},
          {"refused_keys", s.refused_keys},
          {"unacknowledged", s.kept > s.acknowledged ? s.kept - s.acknowledged : 0}};
}

/// "aravis:LEFT", or "left aravis:LEFT, right aravis:RIGHT".
std::string sources_of(const RigConfig& config) {
  std::string text;
  for (const CameraConfig& camera : config.cameras)
    text += (text.empty() ? "" : ", ") + (camera.name.empty() ? "" : camera.name + " ") +
            without_password(*camera.source_uri);
  return text;
}

void run(const RunArguments& arguments) {
  ReportFile json(arguments.json);
  const Logging logging;
  const RigConfig config = configuration(arguments);
  std::vector<TrackedCamera> cameras;
  {
    const EndOnStop opening("sheen-tracker: stopped before the source was open");
    cameras = open_cameras(config, arguments.frames);
  }
  const std::string replayed = cameras.front().source->session(), session = replayed.empty() ? new_session() : replayed;
  std::optional<CurveKeys> keys;
  if (!config.keys.empty()) keys = load_keys(config.keys);
  CaptureSender sender({.endpoint = config.endpoint,
                        .keys = keys,
                        .allowlist = config.allow,
                        .retained = kRetainedKeyframes,
                        .source_session = session,
                        .sent_before = cameras.front().source->session_size(),
                        .motion = motion_of(cameras)});
  std::unique_ptr<MonitorPublisher> publisher;
  if (!arguments.publish.empty())
    publisher = std::make_unique<MonitorPublisher>(
        PublisherOptions{.endpoint = arguments.publish, .keys = keys, .allowlist = config.allow});
  LinkSink sink(sender, cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].sink = &sink.of(i);
    cameras[i].options.source_session = session;
    if (const std::string remarks = cameras[i].source->remarks(); !remarks.empty())
      std::cerr << "sheen-tracker: " << remarks << '\n';
  }
  RigTracking tracking(std::move(cameras));
  std::cerr << "sheen-tracker: " << sources_of(config) << " to " << sender.endpoint() << '\n';

  RigTracking::Hooks hooks{.stop = stop_requested};
  if (publisher)
    hooks.publish = [&](const Status& status) {
      Status with_link = status;
      const SenderStats link = sender.stats();
      for (const auto& [name, count] : link_counters(link)) with_link.gauges["link_" + name] = double(count);
      with_link.gauges["link_connected"] = link.peer_connected;
      publisher->publish(std::move(with_link));
    };
  tell_service_is_ready();
  std::optional<LiveLine> line(std::in_place);
  hooks.progress = [&](const RigReport& so_far) {
    sender.report(frames_for_link(total(so_far)));
    line->show(so_far);
  };
  hooks.failed = [&](const std::string& failure) {
    line.reset();
    std::cerr << "sheen-tracker: the source failed: " << failure << '\n';
    line.emplace();
  };
  RigReport report = tracking.run(hooks);
  tell_service_is_stopping();
  line.reset();
  const TrackingReport all = total(report);
  drain(sender, arguments.linger_s, all.failure_text());
  const SenderStats sent = sender.stats();
  const auto link = link_counters(sent);
  const std::vector<std::uint64_t> unacknowledged = sink.unacknowledged();
  for (std::size_t i = 0; i < report.size(); ++i) report[i].unacknowledged = unacknowledged[i];
  json.write(to_json(report, link));
  std::cerr << "sheen-tracker: " << summary(report) << '\n';
  const std::uint64_t undelivered = link.at("unacknowledged") + all.unsent;
  const std::string words =
      undelivered > 0 ? undelivered_text(undelivered, sender.endpoint(), sent, !replayed.empty()) : "";
  if (undelivered > 0 && all.failure) std::cerr << "sheen-tracker: " << words << '\n';
  if (all.failure) std::rethrow_exception(all.failure);
  if (undelivered > 0) throw Error(words);
}

}  // namespace

void add_run_command(Command& program) {
  Command command = program.subcommand("run", "Tracks cameras, a video or a data set and streams posed images.");
  const auto a = std::make_shared<RunArguments>();
  command.option("--config", a->config, "rig description (TOML): camera, stage, light, source, link, gate");
  command.option(
      "--source", a->source,
      "aravis:ID, video:PATH, video:ADDRESS of a stream, or dataset:DIR; overrides the one camera of --config");
  command.option("--endpoint", a->endpoint, "address to listen on, default tcp://127.0.0.1:7410")
      .check({endpoint_error});
  command.option("--keys", a->keys, "own .key file; without keys only loopback addresses are allowed");
  command.option("--allow", a->allow, "file with the public keys that may connect");
  command.option("--frames", a->frames, "end after this number of frames of each camera; 0 = when the source ends")
      .check(whole_number_in(0, std::int64_t{1} << 53));
  command.option("--json", a->json, "report to write at the end; - for standard output");
  command.option("--publish", a->publish, "address to publish status on, e.g. tcp://127.0.0.1:7411")
      .check({endpoint_error});
  command.option("--linger", a->linger_s, "seconds to wait at the end for acknowledgements")
      .check(number_in(0, 86400))
      .show_default();
  command.callback([a] { run(*a); });
}

}  // namespace sheen
