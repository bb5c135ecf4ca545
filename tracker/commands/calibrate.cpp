// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/camera/camera_file.h"
#include "tracker/calibration/calibration_plots.h"
#include "tracker/calibration/calibration_report.h"
#include "tracker/calibration/image_set.h"
#include "tracker/commands/calibrate_live.h"
#include "tracker/commands/calibrate_photometric.h"
#include "tracker/commands/commands.h"

namespace sheen {
namespace {

struct CalibrateArguments {
  std::vector<std::filesystem::path> images;
  SourceArguments source;
  std::uint64_t frames = 0;
  std::filesystem::path keep, out, json, plots;
  std::string target, lens = "auto";
};

std::vector<TargetView> find_target(const ImageSet& images, const TargetFinder& finder, const Camera* camera) {
  Progress progress(camera ? "fitting corners" : "finding the target", images.files.size());
  std::vector<TargetView> views;
  for_each_image(images, [&](std::size_t i, const GreyImage& image) {
    views.push_back({images.names[i], finder.find(image, camera)});
    progress.update(i + 1);
  });
  const bool any = std::ranges::any_of(views, [](const TargetView& view) { return !view.sightings.empty(); });
  if (const std::string seen = finder.seen_instead(); !any && !seen.empty()) throw Error(seen);
  return views;
}

CalibrationStudy study(const CalibrationTarget& target, const std::vector<TargetView>& views, ImageSize size,
                       const LensFit* fit) {
  std::unique_ptr<Progress> progress;
  return study_calibration(target.points, views, size, fit, [&](int done, int steps) {
    if (!progress) progress = std::make_unique<Progress>("calibrating", static_cast<std::uint64_t>(steps));
    progress->update(static_cast<std::uint64_t>(done));
  });
}

const LensFit* lens_fit_of(const std::string& name) {
  if (name == "auto") return nullptr;
  const LensFit* fit = find_lens_fit(name);
  if (fit) return fit;
  std::string names = "auto";
  for (const LensFit& one : lens_fits()) names += std::string(", ") + one.name;
  throw ConfigError("--lens " + name + " is no lens model; there are " + names);
}

/// What a camera makes of light does not change with its geometry: what the file knows of it is kept.
std::optional<PhotometricCalibration> photometric_part_of(const std::filesystem::path& file, const Camera& camera) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const CameraFile before = load_camera(file);
    if (before.camera.width == camera.width && before.camera.height == camera.height) return before.photometric;
  } catch (const FileError&) {  // no camera: it is written over, as any file
  }
  return std::nullopt;
}

/// Where the images are: given, or taken from a camera for it.
ImageSet images_for(const CalibrateArguments& arguments, const CalibrationTarget& target, const LensFit& fit) {
  if (!arguments.source.given()) return find_images(arguments.images);
  LiveSource source = arguments.source.open("calibrate");
  make_folder(arguments.keep);
  check_writable_folder(arguments.keep);
  collect_views(source, target, fit, arguments.keep, arguments.frames);
  return find_images(std::vector{arguments.keep});
}

void run(const CalibrateArguments& arguments) {
  ReportFile json(arguments.json);
  if (!arguments.out.empty()) check_writable(arguments.out);
  if (!arguments.plots.empty()) check_writable_folder(arguments.plots);
  const LensFit* fit = lens_fit_of(arguments.lens);
  const CalibrationTarget target = parse_target(arguments.target);
  const TargetFinder finder(target);
  const LensFit& first_fit = fit ? *fit : *find_lens_fit("brown");
  const ImageSet images = images_for(arguments, target, first_fit);
  std::optional<EndOnStop> give_up;  // where Ctrl-C ended the taking of images, the second one ends the program
  if (!stop_requested()) give_up.emplace("sheen-tracker: stopped; nothing was written");

  std::vector<TargetView> views = find_target(images, finder, nullptr);
  if (finder.better_with_camera()) {
    const Camera camera = calibrate(target.points, views, images.size, first_fit).camera;
    views = find_target(images, finder, &camera);
  }
  const CalibrationStudy result = study(target, views, images.size, fit);
  const ViewAdvice advice = advise(result);
  std::cout << calibration_text(result, advice) << std::flush;
  if (!arguments.plots.empty() && write_calibration_plots(result, arguments.plots) == PlotFiles::kTableOnly)
    std::cerr << "sheen-tracker: " << kInstallGnuplot << '\n';
  if (json.wanted()) json.write(calibration_json(result, advice, target));
  if (const std::string why = refusal(result, advice); !why.empty()) throw Error("no camera is written: " + why);
  if (arguments.out.empty()) return;
  const Camera& camera = result.calibration.camera;
  CameraFile file{camera, std::sqrt(result.calibration.covariance(0, 0)) / camera.fx};
  file.photometric = photometric_part_of(arguments.out, camera);
  save_camera(file, arguments.out);
  std::cout << arguments.out.string() << ": the camera. In rig.toml: [camera] file = \""
            << arguments.out.filename().string() << "\"\n";
}

}  // namespace

void add_calibrate_command(Command& program) {
  Command command = program.subcommand("calibrate", "Calibrates a camera from images of a target, or live.");
  const auto arguments = std::make_shared<CalibrateArguments>();
  command.option("images", arguments->images, "images of the target, or folders of them");
  arguments->source.add_to(command);
  command.option("--keep", arguments->keep, "with a --source: folder for the images that are taken");
  command.option("--frames", arguments->frames, "with a --source: end after so many frames")
      .check(whole_number_in(0, 1'000'000'000));
  command.option("--target", arguments->target, kTargetSyntax);
  command
      .option("--lens", arguments->lens,
              "auto, pinhole, radial, brown, brown-k3, brown-k3-aspect or fisheye; auto compares them")
      .show_default();
  command.option("--out", arguments->out, "camera.json, which a rig's [camera] file reads");
  command.option("--plots", arguments->plots, "folder for plots: RMS of each image, uncertainty, halves");
  command.option("--json", arguments->json, "report to write; - for standard output");
  add_calibrate_photometric_command(command);
  command.callback([arguments] {
    if (arguments->source.given() == !arguments->images.empty())
      throw ConfigError(arguments->images.empty()
                            ? "images is required: images of the target, or folders of them; or a --source to take them"
                            : "give either images or a --source to take them");
    if (arguments->source.given() && arguments->keep.empty())
      throw ConfigError("--keep is required with a --source: the folder for the images that are taken");
    if (arguments->target.empty()) throw ConfigError(std::string("--target is required: ") + kTargetSyntax);
    run(*arguments);
  });
}

}  // namespace sheen
