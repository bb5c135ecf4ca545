// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/json_number.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/image/color.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/page_export.h"
#include "reconstructor/render/polynomial_texture.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

struct ExportArguments {
  std::string model, out, page, single, about, json;
};

ImageF encoded_picture(const RayPainter& painter, const SavedModel& saved, const LightState& light) {
  const PosedCamera& from = saved.snapshot->cameras().front();
  ImageF picture = painter.paint(*saved.snapshot, from.camera, from.camera_from_object, light).beauty;
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.data()[i] = srgb_encode(std::min(1.0f, std::max(0.0f, picture.data()[i])));
  return picture;
}

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

void export_polynomials(const ExportArguments& arguments) {
  ReportFile json(arguments.json);
  install_stop_signals();
  const SavedModel saved = open_model(arguments.model);
  const std::vector<LightState> lights = saved.snapshot->lights();
  if (saved.snapshot->light_kind() != LightKind::kDirectional || lights.empty())
    throw ConfigError(arguments.model + ": only models of far lights that move can be exported: an irradiance field " +
                      "of a list of directions");
  const std::filesystem::path out = arguments.out;
  const bool ptm = out.extension() == ".ptm";
  if (ptm)
    check_writable(out);
  else
    check_writable_folder(out);
  const RayPainter painter(saved.snapshot->mesh());
  const Camera& camera = saved.snapshot->cameras().front().camera;
  PolynomialFit fit(camera.width, camera.height);
  Progress progress("fitting", 2 * lights.size());
  std::size_t done = 0;
  const auto next = [&] {
    if (stop_requested()) throw Error("stopped before it was exported");
    progress.update(++done);
  };
  for (const LightState& light : lights) {
    fit.add(light.position, encoded_picture(painter, saved, light));
    next();
  }
  const PolynomialTexture texture = fit.texture();
  double squares = 0;
  for (const LightState& light : lights) {
    const ImageF truth = encoded_picture(painter, saved, light), shown = texture.picture(light.position);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double shown_value = std::min(1.0, std::max(0.0, static_cast<double>(shown.data()[i])));
      squares += std::pow(shown_value - static_cast<double>(truth.data()[i]), 2) /
                 static_cast<double>(truth.size() * lights.size());
    }
    next();
  }
  if (ptm)
    write_ptm(out, texture);
  else
    write_relight(out, texture);
  const double psnr_db = -10 * std::log10(squares);
  std::printf("%s written; its polynomials show the model's %zu lights with %.2f dB\n", out.c_str(), lights.size(),
              psnr_db);
  json.write(nlohmann::json{{"lights", lights.size()}, {"psnr_db", json_number(psnr_db)}}.dump(2) + "\n");
}

}  // namespace

void add_export_command(Command& program) {
  auto arguments = std::make_shared<ExportArguments>();
  Command command = program.subcommand(
      "export",
      "Writes a model for others: a surface light field as a page for browsers, an irradiance field of far lights as "
      "polynomial texture maps.");
  command.option("model", arguments->model, "saved model: a file or a folder").required();
  command.option("--page", arguments->page, "folder to write the page to, for any web server");
  command.option("--single", arguments->single, "the page as one file, which opens without a server (.html)");
  Option about =
      command.option("--about", arguments->about,
                     "file (JSON) of what the page says: its title, a text, notes on the object, the first view");
  const Option out = command.option("--out", arguments->out,
                                    "FILE.ptm, or a folder in the format of the relight tools, which OpenLIME shows");
  Option json = command.option("--json", arguments->json, "report to write; - for standard output");
  json.needs(out);
  about.excludes({out});
  command.callback([arguments] {
    if (arguments->page.empty() && arguments->single.empty() && arguments->out.empty())
      throw ConfigError("export: --page, --single or --out says what to write");
    export_page(*arguments);
    if (!arguments->out.empty()) export_polynomials(*arguments);
  });
}

}  // namespace sheen
