// SPDX-License-Identifier: Apache-2.0
#include <ifaddrs.h>
#include <net/if.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/errors.h"
#include "common/link/transport.h"
#include "tracker/commands/commands.h"
#include "tracker/rig_config.h"
#include "tracker/sources/aravis_devices.h"

namespace sheen {
namespace {

constexpr long kReceiveBuffer = 8 << 20;  ///< bytes; 10 frames of 786 KB, so that a busy moment costs no packet
constexpr long kJumboMtu = 9000;

enum class Finding { kOk, kWarn, kFail };
constexpr const char* kFindingNames[] = {"OK", "WARN", "FAIL"};

struct Check {
  std::string name;
  Finding finding = Finding::kOk;
  std::string text;  ///< what was found, and what to do
};

long read_number(const std::filesystem::path& file) {
  std::ifstream in(file);
  long value = -1;
  in >> value;
  return in ? value : -1;
}

Check check_cameras() {
  const auto devices = discover_cameras();
  if (devices.empty())
    return {"cameras", Finding::kWarn,
            "no camera answered; check cable, power and that the network interface has an address in the camera's "
            "subnet"};
  std::string list;
  for (const CameraDevice& device : devices) list += (list.empty() ? "" : ", ") + device.id;
  return {"cameras", Finding::kOk, list};
}

Check check_receive_buffer() {
  const long bytes = read_number("/proc/sys/net/core/rmem_max");
  if (bytes < 0) return {"receive buffer", Finding::kWarn, "net.core.rmem_max cannot be read"};
  if (bytes < kReceiveBuffer)
    return {"receive buffer", Finding::kWarn,
            "net.core.rmem_max is " + std::to_string(bytes) +
                "; set it: sysctl -w net.core.rmem_max=" + std::to_string(kReceiveBuffer)};
  return {"receive buffer", Finding::kOk, "net.core.rmem_max is " + std::to_string(bytes)};
}

/// Interfaces that are up and could carry a camera; virtual ones have no device behind them.
std::vector<Check> check_interfaces() {
  std::set<std::string> names;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {{"interfaces", Finding::kWarn, "cannot be listed"}};
  for (const ifaddrs* i = list; i; i = i->ifa_next)
    if ((i->ifa_flags & IFF_UP) && !(i->ifa_flags & IFF_LOOPBACK)) names.insert(i->ifa_name);
  freeifaddrs(list);
  std::vector<Check> checks;
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

/// Whether something loads; what it throws is the finding.
Check check_loading(const std::string& name, const std::function<std::string()>& load) {
  try {
    return {name, Finding::kOk, load()};
  } catch (const Error& error) {
    return {name, Finding::kFail, error.what()};
  }
}

Check check_key(const std::filesystem::path& file) {
  Check check = check_loading("keys", [&] { return load_keys(file), file.string(); });
  std::error_code error;
  const auto others = std::filesystem::perms::group_all | std::filesystem::perms::others_all;
  if (check.finding == Finding::kOk &&
      (std::filesystem::status(file, error).permissions() & others) != std::filesystem::perms::none)
    return {"keys", Finding::kFail, file.string() + " is open to other users; chmod 600 " + file.string()};
  return check;
}

void check_config(const std::filesystem::path& file, std::vector<Check>& checks) {
  RigConfig config;
  checks.push_back(check_loading("configuration", [&] {
    config = load_rig_config(file);
    return file.string();
  }));
  if (checks.back().finding == Finding::kFail) return;
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
  if (!config.keys.empty()) checks.push_back(check_key(config.keys));
}

void print(const std::vector<Check>& checks, bool json) {
  if (!json) {
    for (const Check& check : checks)
      std::cout << kFindingNames[int(check.finding)] << '\t' << check.name << ": " << check.text << '\n';
    return;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const Check& check : checks)
    list.push_back({{"check", check.name}, {"finding", kFindingNames[int(check.finding)]}, {"text", check.text}});
  std::cout << list.dump(2) << '\n';
}

struct DoctorArguments {
  std::filesystem::path config, keys;
  bool json = false;
};

void examine(const DoctorArguments& arguments) {
  std::vector<Check> checks{check_cameras(), check_receive_buffer()};
  const auto interfaces = check_interfaces();
  checks.insert(checks.end(), interfaces.begin(), interfaces.end());
  if (!arguments.config.empty()) check_config(arguments.config, checks);
  if (!arguments.keys.empty()) checks.push_back(check_key(arguments.keys));
  print(checks, arguments.json);
  for (const Check& check : checks)
    if (check.finding == Finding::kFail) throw Error(check.name + ": " + check.text);
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("doctor", "Say what is wrong with this setup and what to do");
  const auto arguments = std::make_shared<DoctorArguments>();
  command->add_option("--config", arguments->config, "Also check this rig description and the files it names");
  command->add_option("--keys", arguments->keys, "Also check this .key file");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { examine(*arguments); });
}

}  // namespace sheen
