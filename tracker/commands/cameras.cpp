// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "tracker/commands/commands.h"
#include "tracker/sources/aravis_devices.h"

namespace sheen {
namespace {

void list_cameras(bool json) {
  const std::vector<CameraDevice> devices = discover_cameras();
  if (json) {
    nlohmann::json list = nlohmann::json::array();
    for (const CameraDevice& d : devices)
      list.push_back({{"source", "aravis:" + d.id},
                      {"vendor", d.vendor},
                      {"model", d.model},
                      {"serial", d.serial},
                      {"protocol", d.protocol},
                      {"address", d.address}});
    std::cout << list.dump(2) << '\n';
    return;
  }
  for (const CameraDevice& d : devices)
    std::cout << "aravis:" << d.id << "  " << d.vendor << ' ' << d.model << "  " << d.protocol << ' ' << d.address
              << '\n';
  if (devices.empty())
    std::cout << "no GigE Vision or USB3 Vision camera answered; a camera on another subnet can still be opened by its "
                 "address: --source aravis:ADDRESS\n";
}

}  // namespace

void add_cameras_command(Command& program) {
  Command command = program.subcommand("cameras", "Lists the GigE Vision and USB3 Vision cameras that answer.");
  const auto json = std::make_shared<bool>(false);
  command.flag("--json", *json, "print JSON");
  command.callback([json] { list_cameras(*json); });
}

}  // namespace sheen
