// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/setup_checks.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kConnectTimeout{1500};

struct DoctorArguments {
  std::string mesh, session, endpoint = "tcp://127.0.0.1:7410", keys, tracker_key;
  int monitor_port = 7480;
  bool json = false;
};

std::vector<SetupCheck> examine(const DoctorArguments& arguments) {
  std::vector<SetupCheck> checks{check_processor(), check_display(), check_monitor_port(arguments.monitor_port)};
  const auto add = [&checks](std::vector<SetupCheck> more) { checks.insert(checks.end(), more.begin(), more.end()); };
  if (!arguments.mesh.empty()) add(check_mesh(arguments.mesh));
  if (!arguments.session.empty()) add(check_session(arguments.session));
  if (!arguments.keys.empty()) checks.push_back(check_secret_key(arguments.keys));
  if (!arguments.tracker_key.empty()) checks.push_back(check_public_key(arguments.tracker_key));
  checks.push_back(check_endpoint(arguments.endpoint, !arguments.keys.empty(), kConnectTimeout));
  return checks;
}

void print(const std::vector<SetupCheck>& checks, bool json) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SetupCheck& check : checks) {
    if (json)
      list.push_back({{"check", check.name}, {"finding", to_string(check.finding)}, {"text", check.text}});
    else
      std::cout << to_string(check.finding) << '\t' << check.name << ": " << check.text << '\n';
  }
  if (json) std::cout << list.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
}

void doctor(const DoctorArguments& arguments) {
  const std::vector<SetupCheck> checks = examine(arguments);
  print(checks, arguments.json);
  const auto failed = std::count_if(checks.begin(), checks.end(),
                                    [](const SetupCheck& check) { return check.finding == Finding::kFail; });
  if (failed > 0) throw Error(std::to_string(failed) + " of " + std::to_string(checks.size()) + " checks failed");
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* command = app.add_subcommand("doctor", "Says what is wrong with a reconstructor's setup and what to do.");
  command->add_option("--mesh", arguments->mesh, "the object's mesh");
  command->add_option("--session", arguments->session, "folder of the session to record or to go on with");
  command->add_option("--endpoint", arguments->endpoint, "of the tracker")->capture_default_str();
  command->add_option("--keys", arguments->keys, "the reconstructor's .key file");
  command->add_option("--tracker-key", arguments->tracker_key, "the tracker's .pub file");
  command->add_option("--monitor-port", arguments->monitor_port, "of the status page")->capture_default_str();
  command->add_flag("--json", arguments->json, "for machines");
  command->callback([arguments] { doctor(*arguments); });
}

}  // namespace sheen
