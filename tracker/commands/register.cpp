// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/image/image_io.h"
#include "tracker/calibration/posed_images.h"
#include "tracker/calibration/registration.h"
#include "tracker/calibration/registration_overlay.h"
#include "tracker/commands/commands.h"

namespace sheen {
namespace {

constexpr std::size_t kMostImages = 32;

struct RegisterArguments {
  std::string images, mesh, points, out, overlay, json, unit = "m";
  bool free_scale = false;
};

const std::map<std::string, double> kUnits{{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"inch", 0.0254}};

bool any_pixels(const Correspondences& picked) {
  return std::any_of(picked.points.begin(), picked.points.end(), [](const auto& p) { return !p.pixels.empty(); });
}

void register_mesh_on_stage(const RegisterArguments& arguments) {
  ReportFile json(arguments.json);
  for (const std::string& file : {arguments.out, arguments.overlay})
    if (!file.empty()) check_writable(file);
  const EndOnStop give_up("sheen-tracker: stopped; nothing was written");
  if (arguments.images.empty() && arguments.points.empty())
    throw ConfigError("give images with poses (a data set or a session), picked points (--points), or both");
  if (arguments.images.empty() && !arguments.overlay.empty()) throw ConfigError("--overlay needs images");

  const LoadedMesh mesh = load_mesh(arguments.mesh);
  require_no_origin(arguments.mesh, mesh.mesh);
  for (const std::string& warning : mesh.diagnosis.warnings()) std::cerr << arguments.mesh << ": " << warning << '\n';
  std::optional<Correspondences> picked;
  if (!arguments.points.empty()) picked = load_correspondences(arguments.points);
  std::vector<RegistrationImage> images;
  std::map<std::string, PosedCamera> views;
  if (!arguments.images.empty()) {
    const PosedImages posed = open_posed_images(arguments.images);
    images = some_images(posed, kMostImages);
    if (images.size() < 2) throw Error(arguments.images + ": holds fewer than two images with a pose");
    if (picked && any_pixels(*picked)) views = cameras_by_name(posed);
  } else if (any_pixels(*picked)) {
    throw ConfigError(arguments.points + ": has points in images; name the data set or session of these images, too");
  }

  const Registration found =
      register_mesh(mesh.mesh, picked ? &*picked : nullptr, views, images,
                    {arguments.free_scale, kUnits.at(arguments.unit)}, progress_bar("registering"));
  std::cout << registration_text(found) << std::flush;
  for (const std::string& warning : found.warnings) std::cerr << "warning: " << warning << '\n';
  if (!found.not_found.empty())
    throw Error("the mesh's place is not found, and nothing was written: " + found.not_found);
  save_ply(placed(mesh.mesh, found.placement.stage_from_mesh), arguments.out);
  if (!arguments.overlay.empty()) {
    Similarity before;
    before.scale = kUnits.at(arguments.unit);
    if (found.points) before = found.points->placement.stage_from_mesh;
    const std::vector<RegisteredPoint> none;
    write_png(arguments.overlay, registration_overlay(mesh.mesh, images, before, found.placement.stage_from_mesh,
                                                      found.points ? found.points->points : none));
  }
  if (json.wanted()) json.write(registration_json(found));
}

}  // namespace

void add_register_command(Command& program) {
  Command command = program.subcommand(
      "register", "Finds where a mesh stands on the stage: from picked points, from images, or from both.");
  const auto arguments = std::make_shared<RegisterArguments>();
  command.option("images", arguments->images,
                 "data set or session: the mesh is fitted to its masks' outlines, else to its texture");
  command.option("--mesh", arguments->mesh, "PLY, OBJ or OFF").required();
  command.option("--points", arguments->points,
                 "JSON of points of the mesh and their places on the stage or in images (see the user guide); "
                 "without it the mesh must stand about right");
  command.option("--unit", arguments->unit, "of the mesh's numbers: m, cm, mm or inch")
      .check(one_of({"m", "cm", "mm", "inch"}))
      .show_default();
  command.flag("--free-scale", arguments->free_scale, "find the mesh's size, too; else its unit is believed");
  command.option("--out", arguments->out, "PLY file of the mesh as it stands on the stage, metres").required();
  command.option("--overlay", arguments->overlay,
                 "PNG file: the mesh's outline before (red) and after (green) over four of the images");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { register_mesh_on_stage(*arguments); });
}

}  // namespace sheen
