// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/session/session.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/export_page.h"
#include "reconstructor/commands/exports.h"

namespace sheen {
namespace {

struct ExportArguments {
  std::string model, page, single, about, json;
  std::filesystem::path splats, relight;
  SurfaceFiles surface;
  ImageSets images;

  bool has_page() const { return !page.empty() || !single.empty(); }
  bool of_model() const { return !splats.empty() || !relight.empty() || !surface.empty(); }
};

void export_page(const ExportArguments& arguments) {
  const PageText text =
      arguments.about.empty() ? page_text(arguments.model) : read_page_text(arguments.about, arguments.model);
  if (!arguments.page.empty()) {
    write_page(arguments.model, arguments.page, text);
    std::printf("page written to %s: put this folder on any web server\n", arguments.page.c_str());
  }
  if (!arguments.single.empty()) {
    write_single_page(arguments.model, arguments.single, text);
    std::printf("page written to %s: open it in a browser\n", arguments.single.c_str());
  }
}

nlohmann::json export_files(const ExportArguments& arguments) {
  const SavedModel saved = open_model(arguments.model);
  nlohmann::json report = nlohmann::json::object();
  if (!arguments.surface.empty()) report.update(export_surface(*saved.snapshot, arguments.model, arguments.surface));
  if (!arguments.splats.empty()) report["splats"] = export_splats(*saved.snapshot, arguments.model, arguments.splats);
  if (!arguments.relight.empty())
    report["relight"] = export_relight(*saved.snapshot, arguments.model, arguments.relight);
  return report;
}

void export_what_is_asked(const ExportArguments& arguments) {
  if (!arguments.has_page() && !arguments.of_model() && arguments.images.empty())
    throw ConfigError(
        "export: say what to write: of a model --page, --single, --gltf, --ply, --obj, --usdz, --splats or --relight, "
        "of a "
        "session or photographs --transforms or --colmap");
  if ((arguments.has_page() || arguments.of_model()) && !arguments.images.empty())
    throw ConfigError("export: --transforms and --colmap are of a session or photographs, the others of a model");
  if (!arguments.about.empty() && !arguments.has_page()) throw ConfigError("--about: is for --page and --single");
  if (!arguments.json.empty() && !arguments.of_model() && arguments.images.empty())
    throw ConfigError("--json: is not for --page and --single");
  if (arguments.images.empty() && (arguments.images.undistort || !arguments.images.mesh.empty()))
    throw ConfigError("--undistort and --mesh: are for --transforms and --colmap");
  if ((arguments.has_page() || arguments.of_model()) && Session::exists(arguments.model))
    throw ConfigError(arguments.model + ": is a session; its model is " + arguments.model + "/" + kSessionModel);
  ReportFile json(arguments.json);
  if (arguments.has_page()) export_page(arguments);
  install_stop_signals();
  nlohmann::json report;
  if (arguments.of_model()) report = export_files(arguments);
  if (!arguments.images.empty()) report = export_images(arguments.model, arguments.images);
  json.write(report.dump(2) + "\n");
}

}  // namespace

void add_export_command(Command& program) {
  auto arguments = std::make_shared<ExportArguments>();
  Command command =
      program.subcommand("export",
                         "Writes a model for others: a page for browsers, and files of other programs; or "
                         "photographs as a data set of other programs.");
  command
      .option(
          "model", arguments->model,
          "saved model: a file or a folder; for --transforms and --colmap a session, a data set or a list of lights")
      .required();
  command.option("--page", arguments->page, "folder to write the page to, for any web server");
  command.option("--single", arguments->single, "the page as one file, which opens without a server (.html)");
  command.option("--about", arguments->about,
                 "file (JSON) of what the page says: its title, a text, notes on the object, the first view");
  command.option("--gltf", arguments->surface.gltf, "FILE.glb: mesh and its mean look, +Y up");
  command.option("--ply", arguments->surface.ply,
                 "FILE.ply: the same in the mesh's own frame, with FILE.png beside it");
  command.option("--obj", arguments->surface.obj, "FILE.obj: the same, with FILE.mtl and FILE.png beside it");
  command.option("--usdz", arguments->surface.usdz, "FILE.usdz: the same for telephones, +Y up");
  command.option("--splats", arguments->splats,
                 "FILE.ply: Gaussians with spherical harmonics, whose shine moves in every splat viewer; at most 5 MB");
  command.option("--relight", arguments->relight,
                 "an irradiance field of far lights as polynomials: FILE.ptm, or a folder in the format of the relight "
                 "tools, which OpenLIME shows");
  command.option("--transforms", arguments->images.transforms,
                 "new folder for images, masks and cameras as nerfstudio reads them (transforms.json)");
  command.option("--colmap", arguments->images.colmap, "new folder for the same as a COLMAP model, text and binary");
  command.flag("--undistort", arguments->images.undistort, "images as pinhole cameras would have taken them");
  command.option("--mesh", arguments->images.mesh,
                 "mesh whose vertices are the points that trainers begin with; else that of the session's model");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { export_what_is_asked(*arguments); });
}

}  // namespace sheen
