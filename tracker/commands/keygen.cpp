// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/command_line.h"
#include "common/link/transport.h"
#include "tracker/commands/commands.h"

namespace sheen {

void add_keygen_command(Command& program) {
  struct Arguments {
    std::filesystem::path out = ".";
    std::string name;
    bool json = false;
  };
  Command command = program.subcommand("keygen", "Makes a CURVE key pair: NAME.key (secret) and NAME.pub.");
  const auto arguments = std::make_shared<Arguments>();
  command.option("--out", arguments->out, "folder of the key files").show_default();
  command.option("--name", arguments->name, "name of the role or machine").required();
  command.flag("--json", arguments->json, "print JSON");
  command.callback([arguments] {
    const CurveKeys keys = generate_keys(arguments->out, arguments->name);
    const std::string file = (arguments->out / arguments->name).string();
    if (arguments->json)
      std::cout << nlohmann::ordered_json{{"secret_key_file", file + ".key"},
                                          {"public_key_file", file + ".pub"},
                                          {"public_key", keys.public_key}}
                       .dump(2)
                << '\n';
    else
      std::cout << file << ".key written; give " << arguments->name << ".pub to the peers: " << keys.public_key << '\n';
  });
}

}  // namespace sheen
