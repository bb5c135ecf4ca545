// SPDX-License-Identifier: Apache-2.0
#include <ifaddrs.h>
#include <net/if.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <set>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/setup_check.h"
#include "common/link/transport.h"
#include "tracker/commands/commands.h"
#include "tracker/rig_config.h"
#include "tracker/sources/aravis_camera.h"
#include "tracker/sources/aravis_devices.h"
#include "tracker/sources/stream_address.h"
#include "tracker/sources/video_device.h"
#include "tracker/sources/video_source.h"

namespace sheen {
namespace {

constexpr long kReceiveBuffer = 8 << 20;  ///< bytes; 10 frames of 786 KB, so that a busy moment costs no packet
constexpr long kJumboMtu = 9000;
constexpr const char* kPlaceholder = "aravis:CAMERA";

long read_number(const std::filesystem::path& file) {
  std::ifstream in(file);
  long value = -1;
  in >> value;
  return in ? value : -1;
}

SetupCheck check_cameras() {
  const auto devices = discover_cameras();
  if (devices.empty())
    return {"cameras", Finding::kWarn,
            "no camera answered; check cable, power and that the network interface has an address in the camera's "
            "subnet"};
  std::string list;
  for (const CameraDevice& device : devices) list += (list.empty() ? "" : ", ") + device.id;
  return {"cameras", Finding::kOk, list};
}

SetupCheck check_receive_buffer() {
  const long bytes = read_number("/proc/sys/net/core/rmem_max");
  if (bytes < 0) return {"receive buffer", Finding::kWarn, "net.core.rmem_max cannot be read"};
  if (bytes < kReceiveBuffer)
    return {"receive buffer", Finding::kWarn,
            "net.core.rmem_max is " + std::to_string(bytes) +
                "; set it: sysctl -w net.core.rmem_max=" + std::to_string(kReceiveBuffer)};
  return {"receive buffer", Finding::kOk, "net.core.rmem_max is " + std::to_string(bytes)};
}

/// Interfaces that are up and could carry a camera; virtual ones have no device behind them.
std::vector<SetupCheck> check_interfaces() {
  std::set<std::string> names;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {{"interfaces", Finding::kWarn, "cannot be listed"}};
  for (const ifaddrs* i = list; i; i = i->ifa_next)
    if ((i->ifa_flags & IFF_UP) && !(i->ifa_flags & IFF_LOOPBACK)) names.insert(i->ifa_name);
  freeifaddrs(list);
  std::vector<SetupCheck> checks;
  for (const std::string& name : names) {
    if (!std::filesystem::exists("/sys/class/net/" + name + "/device")) continue;
    const long mtu = read_number("/sys/class/net/" + name + "/mtu");
    const std::string text = "MTU " + std::to_string(mtu);
    if (mtu < kJumboMtu)
      checks.push_back(
          {"interface " + name, Finding::kWarn,
           text + "; for a GigE camera set it: ip link set " + name + " mtu " + std::to_string(kJumboMtu)});
    else
      checks.push_back({"interface " + name, Finding::kOk, text});
  }
  return checks;
}

SetupCheck check_key(const std::filesystem::path& file) {
  return check_loading(
      "keys", [&] { return load_keys(file), file.string(); }, "`sheen-tracker keygen` makes keys");
}

/// What a check of one camera is called.
std::string check_name(const std::string& what, const CameraConfig& camera) {
  return camera.name.empty() ? what : what + " of " + camera.name;
}

/// No calibrated camera has its principal point exactly in the middle and no distortion at all.
void check_intrinsics(const CameraConfig& config, std::vector<SetupCheck>& checks) {
  if (!config.camera) {
    checks.push_back(
        {check_name("camera", config), Finding::kWarn, "no [camera]: only data sets can be run; calibrate the camera"});
    return;
  }
  const Camera& camera = *config.camera;
  const bool in_the_middle = camera.cx == (camera.width - 1) / 2.0 && camera.cy == (camera.height - 1) / 2.0;
  if (camera.has_distortion() || !in_the_middle || camera.fx != camera.fy) return;
  checks.push_back({check_name("camera", config), Finding::kFail,
                    "its numbers are an example's or a guess (principal point exactly in the middle, no distortion): "
                    "`sheen-tracker calibrate` finds the true ones"});
}

void check_photometry(const CameraConfig& config, std::vector<SetupCheck>& checks) {
  if (!config.camera) return;
  const std::string name = check_name("light", config);
  if (!config.photometry)
    checks.push_back({name, Finding::kWarn,
                      "what the camera makes of light is not measured: `sheen-tracker calibrate photometric` does it"});
  else if (config.photometry->vignette.none())
    checks.push_back({name, Finding::kWarn, "the response is measured, the vignette is not (--flat)"});
  else
    checks.push_back({name, Finding::kOk, "response and vignette are measured"});
}

void check_source(const CameraConfig& config, std::vector<SetupCheck>& checks) {
  if (!config.source_uri) return;
  const std::string name = check_name("source", config);
  if (*config.source_uri == kPlaceholder)
    checks.push_back({name, Finding::kFail,
                      "\"aravis:CAMERA\" is the example's placeholder; `sheen-tracker cameras` lists the IDs"});
  checks.push_back(
      check_loading(name, [&] { return parse_source_uri(*config.source_uri), without_password(*config.source_uri); }));
}

/// Opens the camera as `run` does: what it does not take is named.
void check_locks(const CameraConfig& config, std::vector<SetupCheck>& checks) {
  if (!config.source_uri || *config.source_uri == kPlaceholder) return;
  const bool aravis = config.source_uri->starts_with("aravis:");
  if (!aravis && !config.source_uri->starts_with("video:")) return;
  const bool is_stream = !aravis && is_stream_address(*config.source_uri);
  checks.push_back(check_loading(check_name("camera settings", config), [&]() -> std::string {
    const std::string target = parse_source_uri(*config.source_uri).target;
    if (is_stream) return open_video(target, config.source)->remarks();
    if (!aravis && !is_video_device(target))
      return open_video(target, config.source), "the file has the size and the rate that are asked for";
    const std::vector<LockedFeature> locks =
        aravis ? AravisCamera(target, config.source).locks() : VideoDevice(target, config.source).locks();
    std::string text;
    for (const LockedFeature& feature : locks)
      text += (text.empty() ? "" : ", ") + feature.feature + " = " + feature.got;
    return text.empty() ? "nothing is to be set, and nothing changes by itself" : text;
  }));
  if (is_stream && checks.back().finding == Finding::kOk) checks.back().finding = Finding::kWarn;  // nothing is locked
}

void check_config(const std::filesystem::path& file, std::vector<SetupCheck>& checks) {
  RigConfig config;
  checks.push_back(check_loading("configuration", [&] {
    config = load_rig_config(file);
    return file.string();
  }));
  if (checks.back().finding == Finding::kFail) return;
  if (config.stage_file)
    checks.push_back(check_loading("stage", [&] {
      return std::to_string(load_stage(*config.stage_file).tags.size()) + " tags in " + config.stage_file->string();
    }));
  else
    checks.push_back({"stage", config.cameras.size() > 1 ? Finding::kFail : Finding::kWarn,
                      "no [stage]: only data sets can be run; make one with `stage`"});
  for (const CameraConfig& camera : config.cameras) {
    check_intrinsics(camera, checks);
    check_source(camera, checks);
    check_photometry(camera, checks);
    check_locks(camera, checks);
  }
  if (!config.keys.empty()) checks.push_back(check_key(config.keys));
}

struct DoctorArguments {
  std::filesystem::path config, keys;
  bool json = false;
};

void examine(const DoctorArguments& arguments) {
  const EndOnStop give_up("sheen-tracker: stopped");
  std::vector<SetupCheck> checks{check_cameras(), check_receive_buffer()};
  const auto interfaces = check_interfaces();
  checks.insert(checks.end(), interfaces.begin(), interfaces.end());
  if (!arguments.config.empty()) check_config(arguments.config, checks);
  if (!arguments.keys.empty()) checks.push_back(check_key(arguments.keys));
  report_checks(checks, arguments.json);
}

}  // namespace

void add_doctor_command(Command& program) {
  Command command = program.subcommand("doctor", "Says what is wrong with the setup of a tracker and what to do.");
  const auto arguments = std::make_shared<DoctorArguments>();
  command.option("--config", arguments->config, "also check this rig description and the files it names");
  command.option("--keys", arguments->keys, "also check this .key file");
  command.flag("--json", arguments->json, "print JSON");
  command.callback([arguments] { examine(*arguments); });
}

}  // namespace sheen
