// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>

#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/setup_checks.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kConnectTimeout{1500};

struct DoctorArguments {
  std::string mesh, session, keys;
  std::vector<std::string> endpoints{"tcp://127.0.0.1:7410"}, tracker_keys;
  int monitor_port = 7480;
  bool json = false;
};

std::vector<SetupCheck> examine(const DoctorArguments& arguments) {
  std::vector<SetupCheck> checks{check_processor(), check_display(), check_monitor_port(arguments.monitor_port)};
  const auto add = [&checks](std::vector<SetupCheck> more) { checks.insert(checks.end(), more.begin(), more.end()); };
  if (!arguments.mesh.empty()) add(check_mesh(arguments.mesh));
  if (!arguments.session.empty()) add(check_session(arguments.session));
  if (!arguments.keys.empty()) checks.push_back(check_secret_key(arguments.keys));
  for (const std::string& key : arguments.tracker_keys) checks.push_back(check_public_key(key));
  for (const std::string& endpoint : arguments.endpoints)
    checks.push_back(check_endpoint(endpoint, !arguments.keys.empty(), kConnectTimeout));
  return checks;
}

void doctor(const DoctorArguments& arguments) {
  report_checks(examine(arguments), arguments.json);
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* command =
      app.add_subcommand("doctor", "Says what is wrong with the setup of a reconstructor and what to do.");
  command->add_option("--mesh", arguments->mesh, "the object's mesh");
  command->add_option("--session", arguments->session, "folder of the session to record or to continue");
  command->add_option("--endpoint", arguments->endpoints, "endpoint of the tracker; once for each of several")
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--keys", arguments->keys, "the reconstructor's .key file");
  command->add_option("--tracker-key", arguments->tracker_keys, "the tracker's .pub file; once for each of several")
      ->allow_extra_args(false);
  command->add_option("--monitor-port", arguments->monitor_port, "port of the status page")->capture_default_str();
  command->add_flag("--json", arguments->json, "print JSON");
  command->callback([arguments] { doctor(*arguments); });
}

}  // namespace sheen
