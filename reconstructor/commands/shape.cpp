// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/files.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/photograph_poses.h"
#include "reconstructor/commands/shape_finding.h"
#include "reconstructor/scene/scene_config.h"

namespace sheen {
namespace {

struct ShapeArguments {
  std::string dataset, from_mesh, out, json;
  std::optional<int> triangles, hold_out;
  ObjectSizeArgument object_size;
};

void shape(const ShapeArguments& arguments) {
  install_stop_signals();
  const EndOnStop give_up("sheen-reconstructor: stopped before it was done");
  ReportFile json(arguments.json);
  check_writable(arguments.out);
  const std::optional<Mesh> rough = rough_mesh(arguments.from_mesh);
  nlohmann::json report, photographs = nlohmann::json::object();
  const std::string dataset = with_poses(arguments.dataset, arguments.object_size, {}, photographs);
  CaptureSet captures = open_capture_set(dataset);
  const int hold_out = arguments.hold_out.value_or(default_scene().settings->hold_out_every);
  const RefinementImages images = training_images(captures, hold_out);
  FoundShape found = find_and_tell(
      images,
      {.triangles = static_cast<std::size_t>(arguments.triangles.value_or(0)), .from = rough ? &*rough : nullptr},
      report);
  report.update(photographs);
  if (const auto metres = arguments.object_size.metres()) bring_to_size(*metres, dataset, found.mesh, captures, report);
  save_ply(found.mesh, arguments.out);
  json.write(report.dump(2) + "\n");
}

}  // namespace

void add_shape_command(Command& program) {
  auto arguments = std::make_shared<ShapeArguments>();
  Command command = program.subcommand("shape", "Finds the shape of an object, a closed mesh, from images of it.");
  command
      .option("dataset", arguments->dataset,
              "folder with transforms.json, a COLMAP model or a Sheen session, or of photographs, whose poses COLMAP "
              "then finds")
      .required();
  command.option("--out", arguments->out, "PLY file of the mesh").required();
  add_rough_mesh_option(command, arguments->from_mesh);
  command.option("--triangles", arguments->triangles, "about so many; without it as many as the images resolve")
      .check(whole_number_in(100, 10'000'000));
  command
      .option("--hold-out", arguments->hold_out,
              "leave out every Nth image where the dataset names no test views, as build does; 0 = none")
      .check(whole_number_in(0, 1'000'000));
  arguments->object_size.add_to(command);
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { shape(*arguments); });
}

}  // namespace sheen
