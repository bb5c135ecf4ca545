// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/stage/stage_sheet.h"
#include "tracker/commands/commands.h"
#include "tracker/commands/stage_survey.h"

namespace sheen {
namespace {

struct StageArguments {
  std::filesystem::path out;
  std::string size_mm = "400x300";
  double tag_mm = 36;
  int first_id = 0;
  bool json = false;
};

void make(const StageArguments& arguments) {
  StageOptions options;
  double width = 0, height = 0;
  int used = 0;
  if (std::sscanf(arguments.size_mm.c_str(), "%lfx%lf%n", &width, &height, &used) != 2 ||
      used != int(arguments.size_mm.size()))
    throw ConfigError("--size \"" + arguments.size_mm + "\" is not a size; write it in millimetres as 400x300");
  options.width_m = width / 1e3;
  options.height_m = height / 1e3;
  options.tag_m = arguments.tag_mm / 1e3;
  options.first_id = arguments.first_id;
  const StageLayout stage = make_stage(options);
  const std::filesystem::path layout = arguments.out.parent_path() / "stage.json";
  write_stage_sheet(stage, arguments.out);
  save_stage(stage, layout);
  if (arguments.json) {
    std::cout << nlohmann::json{{"sheet", arguments.out.string()},
                                {"layout", layout.string()},
                                {"tags", stage.tags.size()},
                                {"hash", stage.hash()}}
                     .dump(2)
              << '\n';
    return;
  }
  std::printf(
      "%s: %zu tags of %g mm. Print at 100 %% and check the 100 mm bar with a ruler.\n%s: where the tags are.\n",
      arguments.out.c_str(), stage.tags.size(), arguments.tag_mm, layout.c_str());
}

}  // namespace

void add_stage_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("stage", "Makes a stage of tags to print, and its layout file.");
  const auto arguments = std::make_shared<StageArguments>();
  command->add_option("--out", arguments->out, "stage.pdf or stage.svg; stage.json is written beside it");
  command->add_option("--size", arguments->size_mm, "size of the board, WIDTHxHEIGHT in mm")->capture_default_str();
  command->add_option("--tag", arguments->tag_mm, "side of a tag's black square in mm")
      ->check(number_in(1, 10000))
      ->capture_default_str();
  command->add_option("--first-id", arguments->first_id, "id of the first tag")
      ->check(whole_number_in(0, 586))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print JSON");
  command->callback([arguments] { make(*arguments); });
}

}  // namespace sheen
