// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/files.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/capture/moved_origin.h"
#include "common/geometry/mesh_io.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/mesh_refining.h"
#include "reconstructor/commands/pose_refining.h"
#include "reconstructor/scene/scene_config.h"
#include "reconstructor/scene/scene_mesh.h"

namespace sheen {
namespace {

struct RefineArguments {
  std::string dataset, mesh, out, poses, config, json;
  std::optional<int> hold_out;
};

void refine(const RefineArguments& arguments) {
  install_stop_signals();
  const EndOnStop give_up("sheen-reconstructor: stopped before it was done");
  ReportFile json(arguments.json);
  const SceneConfig scene = arguments.config.empty() ? default_scene() : load_scene_config(arguments.config);
  ModelSettings& settings = *scene.settings;
  if (arguments.hold_out) settings.hold_out_every = *arguments.hold_out;
  check_writable(arguments.out);
  const bool with_poses = !arguments.poses.empty();
  if (with_poses) {
    check_poses_can_be_refined(arguments.dataset);
    check_writable(arguments.poses);
  }
  const CaptureSet captures = open_capture_set(arguments.dataset);
  const Mesh mesh = load_mesh_and_warn(arguments.mesh, settings, captures.cameras);
  PosedImages posed = posed_images(in_frame_at(mesh.origin, captures), settings.hold_out_every);
  nlohmann::json report;
  const JudgedMesh judged = with_poses ? refine_in_turn(mesh, posed, report)
                                       : refine_and_print(mesh, posed.images.some(posed.training), report);
  report_findings(mesh, arguments.mesh, judged, posed.images.some(posed.training), report);
  const RefinedMesh refined = kept_mesh(mesh, judged);
  const VertexValues values[] = {{"moved", refined.moved}, {"uncertainty", refined.uncertainty}};
  save_ply(refined.mesh, arguments.out, values);
  for (PosedCamera& camera : posed.images.cameras) camera = in_frame_at(-mesh.origin, camera);
  if (with_poses) write_poses(arguments.dataset, posed.images.cameras, arguments.poses);
  json.write(report.dump(2) + "\n");
}

}  // namespace

void add_refine_command(Command& program) {
  auto arguments = std::make_shared<RefineArguments>();
  Command command =
      program.subcommand("refine", "Corrects a mesh, and poses, against the images of a data set or a session.");
  command.option("dataset", arguments->dataset, "folder with transforms.json, a COLMAP model or a Sheen session")
      .required();
  command.option("--mesh", arguments->mesh, "PLY, OBJ or OFF in the dataset's frame").required();
  command.option("--out", arguments->out, "PLY file of the refined mesh").required();
  command.option("--poses", arguments->poses,
                 "refine the poses, too: transforms.json to write; its folder need not be the images'");
  command
      .option("--hold-out", arguments->hold_out,
              "leave out every Nth image where the dataset names no test views, as build does; 0 = none")
      .check(whole_number_in(0, 1'000'000));
  command.option("--config", arguments->config, "scene file (TOML)");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { refine(*arguments); });
}

}  // namespace sheen
