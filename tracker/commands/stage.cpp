// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
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
  std::string size_mm = "400x300", paper;
  double tag_mm = 36;
  bool tag_given = false;
  int first_id = 0;
  bool json = false;
};

struct Paper {
  double longer_m, shorter_m;
};
const std::map<std::string, Paper> kPapers{
    {"A4", {0.297, 0.210}}, {"A3", {0.420, 0.297}}, {"letter", {0.2794, 0.2159}}};

/// The largest board of the paper, its tags in proportion where no size was asked for.
void fit_to_paper(const StageArguments& arguments, StageOptions& options) {
  constexpr double kTagOfWidth = 0.09;
  const Paper& paper = kPapers.at(arguments.paper);
  const BoardSize board = board_for_paper(paper.longer_m, paper.shorter_m);
  options.width_m = board.width_m;
  options.height_m = board.height_m;
  if (!arguments.tag_given) options.tag_m = std::round(1e3 * kTagOfWidth * board.width_m) / 1e3;
}

/// A layout belongs to a sheet that may be glued down already: it is not written over by that of another one.
void check_not_another(const std::filesystem::path& layout, const StageLayout& stage) {
  if (!std::filesystem::exists(layout)) return;
  if (load_stage(layout).hash() != stage.hash())
    throw FileError(layout.string(), "holds another layout; give --out another name, or move it away");
}

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
  if (!arguments.paper.empty()) fit_to_paper(arguments, options);
  options.first_id = arguments.first_id;
  const StageLayout stage = make_stage(options);
  const std::filesystem::path layout = std::filesystem::path(arguments.out).replace_extension(".json");
  check_not_another(layout, stage);
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
      arguments.out.c_str(), stage.tags.size(), 1e3 * options.tag_m, layout.c_str());
}

}  // namespace

void add_stage_command(Command& program) {
  Command command = program.subcommand("stage", "Makes a stage of tags to print, and its layout file.");
  const auto arguments = std::make_shared<StageArguments>();
  command.option("--out", arguments->out, "stage.pdf or stage.svg; the layout beside it has the same name, .json");
  const Option size =
      command.option("--size", arguments->size_mm, "size of the board, WIDTHxHEIGHT in mm").show_default();
  command.option("--paper", arguments->paper, "A4, A3 or letter: the largest board that fits on it; in place of --size")
      .check(one_of({"A4", "A3", "letter"}))
      .excludes({size});
  const Option tag = command.option("--tag", arguments->tag_mm, "side of a tag's black square in mm")
                         .check(number_in(1, 10000))
                         .show_default();
  command.option("--first-id", arguments->first_id, "id of the first tag")
      .check(whole_number_in(0, 586))
      .show_default();
  command.flag("--json", arguments->json, "print JSON");
  add_stage_survey_command(command);
  command.callback([arguments, tag] {
    if (arguments->out.empty()) throw ConfigError("--out is required: stage.pdf or stage.svg");
    arguments->tag_given = tag.given();
    make(*arguments);
  });
}

}  // namespace sheen
