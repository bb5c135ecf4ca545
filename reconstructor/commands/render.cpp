// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/json_number.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/datasets/dataset.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/demand_pictures.h"
#include "reconstructor/commands/film.h"
#include "reconstructor/commands/move_request.h"
#include "reconstructor/commands/picture_layers.h"
#include "reconstructor/commands/picture_names.h"
#include "reconstructor/commands/render_compare.h"
#include "reconstructor/commands/render_lights.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/render/guess_marks.h"
#include "reconstructor/render/model_painter.h"
#include "reconstructor/render/nearest_photograph.h"

namespace sheen {
namespace {

struct RenderArguments {
  std::string model, cameras, compare, out, json;
  std::vector<std::string> layers;
  bool demand = false, mark_guesses = false;
  LightRequest light;
  MoveRequest move;
  FilmRequest film;
  std::optional<int> frames;  ///< of a path
};

PosedCamera posed(const DatasetView& view) {
  return {view.camera, view.camera_from_object};
}

/// Grey picture of one channel, 8 bit.
ExrPart coverage_part(const PaintedView& view) {
  ImageF coverage(view.coverage.width(), view.coverage.height(), 1);
  for (std::size_t i = 0; i < coverage.size(); ++i) coverage.data()[i] = view.coverage.data()[i] / 255.0f;
  return {"coverage", {"Y"}, std::move(coverage), ExrPrecision::kHalf};
}

/// What the model expects of its pictures' errors; the mean over them.
void print_prediction(double predicted_db, const ErrorCalibration& calibration) {
  if (!std::isfinite(predicted_db)) return;
  if (!calibration.known()) {
    std::printf("predicted PSNR of the surface, mean over views: %.2f dB, not calibrated (needs %zu held-out views)\n",
                predicted_db, ErrorCalibration::kFewestViews);
    return;
  }
  std::printf(
      "predicted PSNR of the surface, mean over views: %.2f dB, calibrated on %zu held-out views %.2f dB; %.0f %% of "
      "single views are to lie within %.2f dB of theirs\n",
      predicted_db, calibration.views, calibration.apply(predicted_db).db, 100 * ErrorCalibration::kCoverage,
      calibration.half_width_db);
}

nlohmann::json prediction_json(double predicted_db, const ErrorCalibration& calibration) {
  nlohmann::json json = {{"psnr_db", json_number(predicted_db)}, {"held_out_views", calibration.views}};
  if (calibration.known() && std::isfinite(predicted_db)) {
    json["calibrated_psnr_db"] = calibration.apply(predicted_db).db;
    json["half_width_db"] = calibration.half_width_db;
  }
  return json;
}

/// The views that are far from every photograph.
struct FarViews {
  std::size_t count = 0;
  std::string farthest;
  double most_deg = 0;

  void add(const std::string& view, double away_deg) {
    if (!(away_deg > kFarFromPhotographsDeg)) return;
    ++count;
    if (away_deg <= most_deg) return;
    farthest = view;
    most_deg = away_deg;
  }
  void print(std::size_t views) const {
    if (count == 0) return;
    std::printf("%zu of %zu views are more than %.0f degrees from every photograph: %s is farthest, %.0f degrees\n",
                count, views, kFarFromPhotographsDeg, farthest.c_str(), most_deg);
  }
};

/// Prints it, too: what the bright end of the pictures stands for.
nlohmann::json demand_json(const DemandPictures& demand) {
  nlohmann::json json;
  for (const Demand each : kDemands) json[to_string(each)] = demand.most(each);
  std::printf("what the scene required, bright for: %.3g terms, %.3g samples along a triangle, %.3g bytes a triangle\n",
              demand.most(Demand::kRank), demand.most(Demand::kResolution), demand.most(Demand::kBytes));
  return json;
}

ImageU8 picture_of(const SmoothView& painted, bool mark) {
  ImageU8 picture = straight_srgb8(painted);
  if (mark) mark_guesses(painted, picture);
  return picture;
}

void render(RenderArguments arguments) {
  ReportFile json(arguments.json);
  if (!arguments.compare.empty() && arguments.move.asked())
    throw ConfigError("--compare: its cameras are those of the photographs; leave out --turntable, --orbit and --path");
  if (arguments.frames && arguments.light.path.empty() && arguments.move.keys.empty())
    throw ConfigError("--frames: is for --light-path and --path");
  arguments.move.frames = arguments.frames.value_or(arguments.move.frames);
  arguments.light.frames = arguments.frames.value_or(arguments.light.frames);
  const bool film = is_film(arguments.out);
  if (!arguments.compare.empty()) {
    if (film || arguments.demand || arguments.mark_guesses || !arguments.layers.empty())
      throw ConfigError("--compare: writes pictures into a folder, without --demand, --mark-guesses and --layers");
    return json.write(render_comparison(arguments.model, arguments.compare, arguments.out).dump(2) + "\n");
  }
  if (film && (arguments.demand || !arguments.layers.empty()))
    throw ConfigError("--demand and --layers: a video has no place for them; give a folder");
  if (arguments.light.asked())
    return render_lights(arguments.model, arguments.light, {arguments.mark_guesses, arguments.layers, arguments.film},
                         arguments.out, json);
  if (arguments.cameras.empty() && !arguments.move.asked())
    throw ConfigError(
        "--cameras is required: from where to render; or --turntable, --orbit or --path; or --lights, for a model that "
        "knows moving light");
  const SavedModel saved = open_model(arguments.model);
  const PictureLayers layers(arguments.layers, saved.snapshot, arguments.model);
  const std::vector<DatasetView> cameras = arguments.move.asked()
                                               ? views_of(arguments.move, *saved.snapshot, arguments.model)
                                               : load_cameras(arguments.cameras);
  const ModelPainter painter(*saved.snapshot);
  if (film) {
    const auto picture = [&](std::size_t i) {
      return picture_of(painter.paint(posed(cameras[i]), cameras[i].light), arguments.mark_guesses);
    };
    const nlohmann::json video = write_film(arguments.out, arguments.film, cameras.size(), picture);
    return json.write(nlohmann::json{{"video", video}}.dump(2) + "\n");
  }
  const std::filesystem::path out = arguments.out;
  check_writable_folder(out);
  make_folder(out);

  std::vector<std::string> views;
  for (const DatasetView& view : cameras) views.push_back(view.name);
  const std::vector<std::filesystem::path> names = picture_names(views);
  const bool linear = !arguments.move.asked() || arguments.demand || !arguments.layers.empty();
  std::optional<DemandPictures> demand;
  if (arguments.demand) demand.emplace(*saved.snapshot, arguments.model);
  const ErrorCalibration calibration = calibration_of(saved, arguments.model);
  double predicted_db = 0;
  std::size_t predicted_views = 0;
  auto pictures = nlohmann::json::array();
  FarViews far;
  Progress progress("rendering", cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const PosedCamera from = painter.place_of(posed(cameras[i]));
    const SmoothView painted = painter.paint(posed(cameras[i]), cameras[i].light);
    const double db = predicted_psnr_db(painted, painted.coverage);
    if (std::isfinite(db)) {
      predicted_db += db;
      ++predicted_views;
    }
    const std::string name = (out / names[i]).string();
    make_folder((out / names[i]).parent_path());
    write_png(name + ".png", picture_of(painted, arguments.mark_guesses));
    ExrFile file;
    file.parts.push_back({"beauty", {"R", "G", "B", "A"}, premultiplied(painted), ExrPrecision::kHalf});
    file.parts.push_back({"heuristic", {"Y"}, painted.heuristic, ExrPrecision::kHalf});
    file.parts.push_back(coverage_part(painted));
    if (demand) demand->add(painter.rays().cast(from.camera, from.camera_from_object), from.camera, name, file);
    layers.add(painter.rays(), from, painter.light_of(cameras[i].light), file);
    if (linear) write_exr(name + ".exr", file);
    const double away_deg = nearest_photograph_deg(*saved.snapshot, camera_centre(from.camera_from_object));
    far.add(names[i].string(), away_deg);
    pictures.push_back({{"file", names[i].string()},
                        {"predicted_psnr_db", json_number(db)},
                        {"nearest_photograph_deg", json_number(away_deg)}});
    progress.update(i + 1);
  }
  predicted_db /= static_cast<double>(predicted_views);  // NaN where none has one
  std::printf("%zu views rendered to %s\n", cameras.size(), out.string().c_str());
  far.print(cameras.size());
  print_prediction(predicted_db, calibration);
  nlohmann::json report{{"pictures", pictures}, {"predicted", prediction_json(predicted_db, calibration)}};
  if (demand) report["demand"] = demand_json(*demand);
  json.write(report.dump(2) + "\n");
}

}  // namespace

void add_render_command(Command& program) {
  auto arguments = std::make_shared<RenderArguments>();
  Command command = program.subcommand("render",
                                       "Renders a saved model from given cameras, by one that moves, or in given "
                                       "lights: linear EXR and PNG per view, or "
                                       "a video.");
  command.option("model", arguments->model, "saved model: a file or a folder").required();
  const Option cameras = command.option("--cameras", arguments->cameras,
                                        "transforms.json with the cameras to render, or nerfstudio's camera_path.json");
  Option lights = command.option("--lights", arguments->light.list,
                                 "list of lights (.lp) to render a model of moving light in, one after the other");
  Option luminaires = command.option("--luminaires", arguments->light.luminaires,
                                     "file (JSON) of pictures in lamps that are on together, far and large");
  Option environment =
      command.option("--environment", arguments->light.environment, "map of light from all around (OpenEXR)");
  Option path = command.option("--light-path", arguments->light.path,
                               "list of lights (.lp): one light moves smoothly through them");
  lights.excludes({cameras});
  luminaires.excludes({cameras, lights});
  environment.excludes({cameras, lights, luminaires});
  path.excludes({cameras, lights, luminaires, environment});
  arguments->move.add_to(command, {cameras, lights, luminaires, environment, path});
  command
      .option("--compare", arguments->compare,
              "session, data set or list of lights: each photograph beside the model's picture, and its PSNR")
      .excludes({cameras, lights, luminaires, environment, path});
  command.option("--frames", arguments->frames, "pictures of --light-path or --path; else 60")
      .check(whole_number_in(2, 100'000));
  arguments->film.add_to(command);
  command
      .flag("--demand", arguments->demand,
            "also what the scene required: terms, samples, bytes, as pictures and parts of the EXR")
      .excludes({lights, luminaires, environment, path});
  command
      .option("--layers", arguments->layers,
              "what else the EXR holds, with commas between: depth and normals of the surface; what an intrinsic "
              "lumigraph tells apart")
      .delimiter(',')
      .check(is_layer());
  command.flag("--mark-guesses", arguments->mark_guesses,
               "in the PNGs, stripe what no photograph shows and tint what is imputed");
  command.option("--out", arguments->out, "folder for the pictures, or a video: FILE.mp4 (H.264) or FILE.webm (VP9)")
      .required();
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { render(*arguments); });
}

}  // namespace sheen
