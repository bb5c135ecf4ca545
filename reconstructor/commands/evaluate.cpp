// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/datasets/stored_images.h"
#include "common/geometry/mesh.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/evaluate_lights.h"
#include "reconstructor/evaluation/error_ranking.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/evaluation/held_out.h"

namespace sheen {
namespace {

struct EvaluateArguments {
  std::string model, dataset, truth, object, json;
  bool baselines = false;
};

/// The views that the model never saw, on the pixels of the object that `painter` paints; what it was built from goes
/// to `others`.
std::vector<HeldOutView> read_images(const EvaluateArguments& arguments, const CaptureSet& captures,
                                     const ModelOrigin& origin, const RayPainter& painter, Baselines& others) {
  std::vector<HeldOutView> views;
  std::size_t known_captures = 0;
  Progress progress("evaluating", captures.size);
  for (std::size_t i = 0; i < captures.size; ++i) {
    Capture capture = captures.read(i);
    if (const KnownCapture* known = origin.find(capture)) {
      ++known_captures;
      if (known->camera_from_object) capture.pose.camera_from_object = *known->camera_from_object;
      if (known->status == IngestStatus::kHeldOut) {
        views.push_back(make_held_out_view(capture, known->exposure_gain, painter));
        if (!arguments.truth.empty()) take_truth_from(arguments.truth, views.back());
      } else {
        others.add(capture, known->exposure_gain, known->repeated);
      }
    }
    progress.update(i + 1);
  }
  if (known_captures == 0)
    throw FileError(arguments.dataset, "has none of the images that " + arguments.model +
                                           " was built from; give the data set or session that it was built from");
  if (views.empty())
    throw FileError(arguments.dataset,
                    "has no view that the model never saw; name some in test_filenames, or build with --hold-out");
  return views;
}

void evaluate(const EvaluateArguments& arguments) {
  ReportFile json(arguments.json);
  if (is_light_list(arguments.dataset)) {
    if (arguments.baselines || !arguments.truth.empty())
      throw ConfigError("--baselines and --truth are for views; a list of lights has none");
    json.write(to_text(evaluate_lights(arguments.model, arguments.dataset)));
    return;
  }
  const SavedModel saved = open_model(arguments.model);
  const ModelOrigin origin = origin_of(saved, arguments.model);
  const Eigen::Vector3d& frame = saved.snapshot->mesh().origin;
  const CaptureSet captures = in_frame_at(frame, open_capture_set(arguments.dataset));
  const RayPainter painter(saved.snapshot->mesh());
  const std::unique_ptr<Baselines> others = origin.settings->make_baselines(saved.snapshot, arguments.baselines);
  const std::optional<RayPainter> other_shape =
      arguments.object.empty() ? std::nullopt
                               : std::optional<RayPainter>(in_frame_at(frame, load_mesh(arguments.object).mesh));
  const std::vector<HeldOutView> views =
      read_images(arguments, captures, origin, other_shape ? *other_shape : painter, *others);

  const std::shared_ptr<const Appearance> constant = others->constant_colour();
  const Scores model = score(views, *saved.snapshot, painter), constant_scores = score(views, *constant, painter);
  nlohmann::json report = evaluation_report(model, constant_scores);
  if (std::isfinite(model.psnr_db) && std::isfinite(constant_scores.psnr_db))
    print_scores(model.psnr_db, model.ssim, constant_scores.psnr_db);
  const BaselineHeuristic other = others->heuristic();
  const ErrorRanking ranking = judge_error_ranking(views, *saved.snapshot, other, painter);
  report["error_ranking"] = ranking_report(ranking);
  report["predicted_error"] = prediction_report(model);
  print_predictions(model, ranking, other.title);
  if (arguments.baselines) {
    std::vector<BaselineScores> baselines{{{"constant_colour", "constant colour", constant}, constant_scores}};
    const std::uintmax_t bytes = saved_bytes(arguments.model);
    for (const Baseline& baseline : others->from_photographs(bytes))
      baselines.push_back({baseline, score(views, *baseline.appearance, painter)});
    report["baselines"] = baselines_report(baselines);
    const BaselineScores itself{{.title = std::string(saved.kind->title()) + " (no photograph kept)",
                                 .disk_bytes = static_cast<double>(bytes),
                                 .memory_bytes = static_cast<double>(saved.snapshot->memory_bytes())},
                                model};
    report["bytes"] = bytes_report(itself.baseline);
    print_baselines(baselines, itself);
  }
  json.write(to_text(report));
}

}  // namespace

void add_evaluate_command(Command& program) {
  auto arguments = std::make_shared<EvaluateArguments>();
  Command command =
      program.subcommand("evaluate", "Measures PSNR and SSIM of a saved model on views that it never saw.");
  command.option("model", arguments->model, "saved model: a file or a folder").required();
  command
      .option("dataset", arguments->dataset,
              "the images it was built from, and the held-out ones; of an irradiance field a list of lights (.lp) "
              "that it never saw")
      .required();
  command.flag("--baselines", arguments->baselines,
               "score constant colour, nearest photograph and unstructured lumigraph on the same pixels, the "
               "lumigraph also of photographs that take no more bytes than the model");
  command.option("--truth", arguments->truth,
                 "score against NAME.exr of this folder (linear radiance without noise), not against the images");
  command.option("--object", arguments->object,
                 "mesh whose pixels count, where it is not the model's: before and after `refine` compare on the "
                 "same ones");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { evaluate(*arguments); });
}

}  // namespace sheen
