// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/monitor/monitor_client.h"
#include "reconstructor/monitor/monitor_token.h"

namespace sheen {
namespace {

struct MonitorArguments {
  std::string url = "http://127.0.0.1:7480", token_file;
  bool once = false, json = false;
};

/// A line per second until Ctrl-C; a reconstructor that is away for a while is waited for.
void watch(const MonitorArguments& arguments) {
  const std::string token = monitor_token(arguments.token_file);
  const auto look = [&arguments, &token] {
    const std::string status = fetch_status(arguments.url, token);
    return arguments.json ? status : status_line(status);
  };
  if (arguments.once) {
    std::cout << look() << std::endl;
    return;
  }
  for (;; std::this_thread::sleep_for(std::chrono::seconds(1))) {
    try {
      std::cout << look() << std::endl;
    } catch (const DeviceError& error) {
      std::cerr << error.what() << std::endl;
    }
  }
}

}  // namespace

void add_monitor_command(Command& program) {
  auto arguments = std::make_shared<MonitorArguments>();
  Command command = program.subcommand("monitor", "Watches a running reconstructor from a terminal.");
  command.option("--url", arguments->url, "address of its monitor page").show_default();
  command.option("--token-file", arguments->token_file,
                 "file (mode 600) with the token of the page, if it asks for one; or set SHEEN_MONITOR_TOKEN");
  command.flag("--once", arguments->once, "print one line and end; exit status 1 when nobody answers");
  command.flag("--json", arguments->json, "the whole status as JSON, one per line");
  command.callback([arguments] { watch(*arguments); });
}

}  // namespace sheen
