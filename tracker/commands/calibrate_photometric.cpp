// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/calibrate_photometric.h"

#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "common/base/angle.h"
#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/camera/camera_file.h"
#include "tracker/calibration/photometric_report.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr int kCellsAcross = 32;

struct PhotometricArguments {
  std::vector<fs::path> sweep, dark, flat, grey;
  fs::path exposures, moves, out, json, plots;
  std::string patch;
  ValueFormat format;
  bool evenly_lit = false;
};

/// Lines of NAME and numbers; # begins a comment.
std::map<std::string, std::vector<double>> read_table(const fs::path& file, std::size_t numbers, const char* columns) {
  std::map<std::string, std::vector<double>> table;
  std::istringstream lines(read_file(file));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, rest;
    if (!(words >> name)) continue;
    std::vector<double> values(numbers);
    bool good = true;
    for (double& value : values) good = good && words >> value && std::isfinite(value);
    if (!good || words >> rest)
      throw FileError(file.string(), "line " + std::to_string(number) + " is not \"" + columns + "\"");
    if (!table.emplace(name, values).second)
      throw FileError(file.string(), "line " + std::to_string(number) + " names " + name + " again");
  }
  return table;
}

std::vector<CellImage> read_all(const std::vector<fs::path>& files, const ValueFormat& format, const char* what) {
  Progress progress(what, files.size());
  std::vector<CellImage> images;
  for (const fs::path& file : files) {
    images.push_back(read_cells(file, format, kCellsAcross));
    progress.update(images.size());
  }
  return images;
}

std::vector<double> exposures_of(const std::vector<CellImage>& sweep, const fs::path& list) {
  std::vector<double> exposures;
  if (list.empty()) {
    for (const CellImage& image : sweep) exposures.push_back(image.exposure_s);
    return exposures;
  }
  const auto table = read_table(list, 1, "FILE SECONDS");
  for (const CellImage& image : sweep) {
    const auto found = table.find(image.name);
    if (found == table.end()) throw FileError(list.string(), "does not say the exposure of " + image.name);
    if (!(found->second[0] > 0)) throw FileError(list.string(), "the exposure of " + image.name + " must be above 0");
    exposures.push_back(found->second[0]);
  }
  return exposures;
}

std::vector<FlatImage> flats_of(std::vector<CellImage> images, const fs::path& list) {
  std::map<std::string, std::vector<double>> table;
  if (!list.empty()) table = read_table(list, 3, "FILE TURN_DEGREES SHIFT_X SHIFT_Y");
  std::vector<FlatImage> flats;
  for (CellImage& image : images) {
    TargetMove move;
    if (!list.empty()) {
      const auto found = table.find(image.name);
      if (found == table.end()) throw FileError(list.string(), "does not say how the target stands in " + image.name);
      const std::vector<double>& numbers = found->second;
      move = {numbers[0] * kDegree, {numbers[1], numbers[2]}};
    }
    flats.push_back({std::move(image), move});
  }
  return flats;
}

Patch parse_patch(const std::string& text) {
  Patch patch;
  int used = 0;
  if (text.empty()) return patch;
  if (std::sscanf(text.c_str(), "%d,%d,%dx%d%n", &patch.x, &patch.y, &patch.width, &patch.height, &used) != 4 ||
      used != int(text.size()) || patch.empty() || patch.x < 0 || patch.y < 0)
    throw ConfigError("--patch " + text + " is no part of an image; write X,Y,WIDTHxHEIGHT in pixels");
  return patch;
}

/// The file that the result is written into: a camera whose geometry is known.
CameraFile camera_for(const fs::path& file, ImageSize size) {
  if (!fs::exists(file))
    throw FileError(file.string(), "does not exist; calibrate the geometry first: `sheen-tracker calibrate --out`");
  CameraFile camera = load_camera(file);
  if (camera.camera.width != size.width || camera.camera.height != size.height)
    throw FileError(file.string(), "is of a camera of " + std::to_string(camera.camera.width) + " x " +
                                       std::to_string(camera.camera.height) + " pixels, the images have " +
                                       std::to_string(size.width) + " x " + std::to_string(size.height));
  return camera;
}

void run(const PhotometricArguments& arguments) {
  ReportFile json(arguments.json);
  if (!arguments.plots.empty()) check_writable_folder(arguments.plots);
  const EndOnStop give_up("sheen-tracker: stopped; nothing was written");
  const Patch patch = parse_patch(arguments.patch);
  const std::vector<CellImage> sweep = read_all(arguments.sweep, arguments.format, "reading the sweep");
  CameraFile camera;
  if (!arguments.out.empty()) camera = camera_for(arguments.out, sweep[0].size);
  const std::vector<double> exposures = exposures_of(sweep, arguments.exposures);
  const std::vector<CellImage> dark = read_all(arguments.dark, arguments.format, "reading dark frames");

  PhotometricStudy study;
  for (const CellImage& image : sweep) study.names.push_back(image.name);
  study.size = sweep[0].size;
  study.response = fit_response(sweep, exposures, dark);
  if (!arguments.flat.empty()) {
    const auto flats = flats_of(read_all(arguments.flat, arguments.format, "reading flat images"), arguments.moves);
    study.vignette = fit_vignette(flats, study.response.response, study.response.saturation,
                                  arguments.evenly_lit ? TargetLight::kEven : TargetLight::kUnknown);
    if (study.vignette->size.width != study.size.width || study.vignette->size.height != study.size.height)
      throw Error("the flat images differ from the sweep in size; give one camera's images");
  }
  if (!arguments.grey.empty())
    study.balance = fit_balance(read_all(arguments.grey, arguments.format, "reading grey images"), patch,
                                study.response, study.vignette ? &*study.vignette : nullptr);

  std::cout << photometric_text(study) << std::flush;
  if (!arguments.plots.empty() && write_photometric_plots(study, arguments.plots) == PlotFiles::kTableOnly)
    std::cerr << "sheen-tracker: " << kInstallGnuplot << '\n';
  if (json.wanted()) json.write(photometric_json(study));
  if (arguments.out.empty()) return;
  camera.photometric = calibration_of(study);
  save_camera(camera, arguments.out);
  std::cout << arguments.out.string() << ": what the camera makes of light was added\n";
}

}  // namespace

void add_calibrate_photometric_command(Command& calibrate) {
  Command command =
      calibrate.subcommand("photometric", "Measures what the camera makes of light: response, vignette, balance.");
  const auto a = std::make_shared<PhotometricArguments>();
  command.option("--sweep", a->sweep, "images of one scene at several exposures; nothing else may change").required();
  command.option("--exposures", a->exposures, "their exposures where EXIF has none: lines of FILE SECONDS");
  command.option("--dark", a->dark, "images with the lens covered");
  command.option("--flat", a->flat, "images of a flat white target that fills the image");
  const Option moves =
      command.option("--moves", a->moves,
                     "how the target and its light stand in them: lines of FILE TURN_DEGREES SHIFT_X SHIFT_Y (px)");
  command.flag("--evenly-lit", a->evenly_lit, "the flat target is known to be equally bright all over")
      .excludes({moves});
  command.option("--grey", a->grey, "images of a grey target, for the white balance");
  command.option("--patch", a->patch, "where in them the grey target is: X,Y,WIDTHxHEIGHT in pixels");
  command
      .option("--mosaic", a->format.mosaic,
              "colours of the first two sites of raw images with one channel: RG, GR, GB or BG")
      .check(one_of({"RG", "GR", "GB", "BG"}));
  command.option("--bits", a->format.bits, "of the values in 16-bit files, as 12").check(whole_number_in(9, 16));
  command.option("--out", a->out, "camera.json that `calibrate` wrote; the result is added to it");
  command.option("--plots", a->plots, "folder for plots: response, exposures, vignette");
  command.option("--json", a->json, "report to write; - for standard output");
  command.callback([a] { run(*a); });
}

}  // namespace sheen
