// SPDX-License-Identifier: Apache-2.0
#include <ifaddrs.h>
#include <net/if.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>

#include "common/base/setup_check.h"
#include "common/link/transport.h"
#include "tracker/commands/commands.h"
#include "tracker/rig_config.h"
#include "tracker/sources/aravis_camera.h"
#include "tracker/sources/aravis_devices.h"

namespace sheen {
namespace {

constexpr long kReceiveBuffer = 8 << 20;  ///< bytes; 10 frames of 786 KB, so that a busy moment costs no packet
constexpr long kJumboMtu = 9000;

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

/// No calibrated camera has its principal point exactly in the middle and no distortion at all.
void check_camera(const Camera& camera, std::vector<SetupCheck>& checks) {
  const bool in_the_middle = camera.cx == (camera.width - 1) / 2.0 && camera.cy == (camera.height - 1) / 2.0;
  if (camera.has_distortion() || !in_the_middle || camera.fx != camera.fy) return;
  checks.push_back({"camera", Finding::kFail,
                    "its numbers are an example's or a guess (principal point exactly in the middle, no distortion): "
                    "`sheen-tracker calibrate` finds the true ones"});
}

void check_photometry(const RigConfig& config, std::vector<SetupCheck>& checks) {
  if (!config.camera) return;
  if (!config.photometry)
    checks.push_back({"light", Finding::kWarn,
                      "what the camera makes of light is not measured: `sheen-tracker calibrate photometric` does it"});
  else if (config.photometry->vignette.none())
    checks.push_back({"light", Finding::kWarn, "the response is measured, the vignette is not (--flat)"});
  else
    checks.push_back({"light", Finding::kOk, "response and vignette are measured"});
}

/// Opens the camera as `run` does: what it does not take is named.
void check_locks(const RigConfig& config, std::vector<SetupCheck>& checks) {
  if (!config.source_uri || !config.source_uri->starts_with("aravis:") || config.source_uri == "aravis:CAMERA") return;
  checks.push_back(check_loading("camera settings", [&] {
    const AravisCamera camera(parse_source_uri(*config.source_uri).target, config.source);
    std::string text;
    for (const LockedFeature& feature : camera.locks())
      text += (text.empty() ? "" : ", ") + feature.feature + " = " + feature.got;
    return text.empty() ? std::string("nothing is to be set, and nothing changes by itself") : text;
  }));
}

void check_config(const std::filesystem::path& file, std::vector<SetupCheck>& checks) {
  RigConfig config;
  checks.push_back(check_loading("configuration", [&] {
    config = load_rig_config(file);
    return file.string();
  }));
  if (checks.back().finding == Finding::kFail) return;
  if (config.camera) check_camera(*config.camera, checks);
  if (config.source_uri == "aravis:CAMERA")
    checks.push_back({"source", Finding::kFail,
                      "\"aravis:CAMERA\" is the example's placeholder; `sheen-tracker cameras` lists the IDs"});
  if (!config.camera)
    checks.push_back({"camera", Finding::kWarn, "no [camera]: only data sets can be run; calibrate the camera"});
  if (config.stage_file)
    checks.push_back(check_loading("stage", [&] {
      return std::to_string(load_stage(*config.stage_file).tags.size()) + " tags in " + config.stage_file->string();
    }));
  else
    checks.push_back({"stage", Finding::kWarn, "no [stage]: only data sets can be run; make one with `stage`"});
  if (config.source_uri)
    checks.push_back(check_loading("source", [&] { return parse_source_uri(*config.source_uri), *config.source_uri; }));
  check_photometry(config, checks);
  check_locks(config, checks);
  if (!config.keys.empty()) checks.push_back(check_key(config.keys));
}

struct DoctorArguments {
  std::filesystem::path config, keys;
  bool json = false;
};

void examine(const DoctorArguments& arguments) {
  std::vector<SetupCheck> checks{check_cameras(), check_receive_buffer()};
  const auto interfaces = check_interfaces();
  checks.insert(checks.end(), interfaces.begin(), interfaces.end());
  if (!arguments.config.empty()) check_config(arguments.config, checks);
  if (!arguments.keys.empty()) checks.push_back(check_key(arguments.keys));
  report_checks(checks, arguments.json);
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("doctor", "Says what is wrong with the setup of a tracker and what to do.");
  const auto arguments = std::make_shared<DoctorArguments>();
  command->add_option("--config", arguments->config, "also check this rig description and the files it names");
  command->add_option("--keys", arguments->keys, "also check this .key file");
  command->add_flag("--json", arguments->json, "print JSON");
  command->callback([arguments] { examine(*arguments); });
}

}  // namespace sheen
