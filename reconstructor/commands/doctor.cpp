// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "common/base/command_line.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/setup_checks.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kConnectTimeout{1500};

struct DoctorArguments {
  std::string mesh, session, keys;
  std::vector<std::string> endpoints{"tcp://127.0.0.1:7410"}, tracker_keys;
  int monitor_port = 7480;
  bool json = false, numerics = false;
};

std::vector<SetupCheck> examine(const DoctorArguments& arguments) {
  if (arguments.numerics) return check_numerics();
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

void add_doctor_command(Command& program) {
  auto arguments = std::make_shared<DoctorArguments>();
  Command command =
      program.subcommand("doctor", "Says what is wrong with the setup of a reconstructor and what to do.");
  command.option("--mesh", arguments->mesh, "the object's mesh");
  command.option("--session", arguments->session, "folder of the session to record or to continue");
  command.option("--endpoint", arguments->endpoints, "endpoint of the tracker; once for each of several")
      .one_each_time()
      .show_default();
  command.option("--keys", arguments->keys, "the reconstructor's .key file");
  command.option("--tracker-key", arguments->tracker_keys, "the tracker's .pub file; once for each of several")
      .one_each_time();
  command.option("--monitor-port", arguments->monitor_port, "port of the status page").show_default();
  command.flag("--numerics", arguments->numerics,
               "instead: whether the factorization holds at the extremes on this machine; takes seconds");
  command.flag("--json", arguments->json, "print JSON");
  command.callback([arguments] { doctor(*arguments); });
}

}  // namespace sheen
