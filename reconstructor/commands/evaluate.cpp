// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/evaluate.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/datasets/stored_images.h"
#include "common/geometry/mesh.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/evaluate_lights.h"
#include "reconstructor/evaluation/error_ranking.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/evaluation/held_out.h"

namespace sheen {
namespace {

struct EvaluateArguments {
  std::string model, json;
  EvaluateRequest request;
};

/// The views that the model never saw, on the pixels of the object that `painter` paints; what it was built from goes
/// to `others`.
std::vector<HeldOutView> read_images(const std::string& model, const EvaluateRequest& request,
                                     const CaptureSet& captures, const ModelOrigin& origin, const RayPainter& painter,
                                     Baselines& others) {
  std::vector<HeldOutView> views;
  std::size_t known_captures = 0;
  Progress progress("evaluating", captures.size);
  for (std::size_t i = 0; i < captures.size; ++i) {
    if (stop_requested()) throw Error("stopped after " + std::to_string(i) + " images; nothing was measured");
    Capture capture = captures.read(i);
    if (const KnownCapture* known = origin.find(capture)) {
      ++known_captures;
      if (known->camera_from_object) capture.pose.camera_from_object = *known->camera_from_object;
      if (known->status == IngestStatus::kHeldOut) {
        views.push_back(make_held_out_view(capture, known->exposure_gain, painter));
        if (!request.truth.empty()) take_truth_from(request.truth, views.back());
      } else {
        others.add(capture, known->exposure_gain, known->repeated);
      }
    }
    progress.update(i + 1);
  }
  if (known_captures == 0)
    throw FileError(request.dataset, "has none of the images that " + model +
                                         " was built from; give the data set or session that it was built from");
  if (views.empty())
    throw FileError(request.dataset,
                    "has no view that the model never saw; name some in test_filenames, or build with --hold-out");
  return views;
}

}  // namespace

nlohmann::json evaluate(const SavedModel& saved, const std::string& name, const EvaluateRequest& request) {
  if (is_light_list(request.dataset)) {
    if (request.baselines || !request.truth.empty())
      throw ConfigError("--baselines and --truth are for views; a list of lights has none");
    return evaluate_lights(saved, name, request.dataset, request.told);
  }
  const ModelOrigin origin = origin_of(saved, name);
  const Eigen::Vector3d& frame = saved.snapshot->mesh().origin;
  const CaptureSet captures = in_frame_at(frame, open_capture_set(request.dataset));
  const RayPainter painter(saved.snapshot->mesh());
  const std::unique_ptr<Baselines> others = origin.settings->make_baselines(saved.snapshot, request.baselines);
  const std::optional<RayPainter> other_shape =
      request.object.empty() ? std::nullopt
                             : std::optional<RayPainter>(in_frame_at(frame, load_mesh(request.object).mesh));
  const std::vector<HeldOutView> views =
      read_images(name, request, captures, origin, other_shape ? *other_shape : painter, *others);

  const std::shared_ptr<const Appearance> constant = others->constant_colour();
  const Scores model = score(views, *saved.snapshot, painter), constant_scores = score(views, *constant, painter);
  nlohmann::json report = evaluation_report(model, constant_scores);
  if (request.told && std::isfinite(model.psnr_db) && std::isfinite(constant_scores.psnr_db))
    print_scores(model.psnr_db, model.ssim, constant_scores.psnr_db);
  const BaselineHeuristic other = others->heuristic();
  const ErrorRanking ranking = judge_error_ranking(views, *saved.snapshot, other, painter);
  report["error_ranking"] = ranking_report(ranking);
  report["predicted_error"] = prediction_report(model);
  if (request.told) print_predictions(model, ranking, other.title);
  if (request.baselines) {
    std::vector<BaselineScores> baselines{{{"constant_colour", "constant colour", constant}, constant_scores}};
    const std::uintmax_t bytes = saved_bytes(name);
    for (const Baseline& baseline : others->from_photographs(bytes))
      baselines.push_back({baseline, score(views, *baseline.appearance, painter)});
    report["baselines"] = baselines_report(baselines);
    const BaselineScores itself{{.title = std::string(saved.kind->title()) + " (no photograph kept)",
                                 .disk_bytes = static_cast<double>(bytes),
                                 .memory_bytes = static_cast<double>(saved.snapshot->memory_bytes())},
                                model};
    report["bytes"] = bytes_report(itself.baseline);
    if (request.told) print_baselines(baselines, itself);
  }
  return report;
}

void add_evaluate_command(Command& program) {
  auto arguments = std::make_shared<EvaluateArguments>();
  Command command =
      program.subcommand("evaluate", "Measures PSNR and SSIM of a saved model on views that it never saw.");
  command.option("model", arguments->model, "saved model: a file or a folder").required();
  command
      .option("dataset", arguments->request.dataset,
              "the images it was built from, and the held-out ones; of an irradiance field a list of lights (.lp) "
              "that it never saw")
      .required();
  command.flag("--baselines", arguments->request.baselines,
               "score constant colour, nearest photograph and unstructured lumigraph on the same pixels, the "
               "lumigraph also of photographs that take no more bytes than the model");
  command.option("--truth", arguments->request.truth,
                 "score against NAME.exr of this folder (linear radiance without noise), not against the images");
  command.option("--object", arguments->request.object,
                 "mesh whose pixels count, where it is not the model's: before and after `refine` compare on the "
                 "same ones");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] {
    ReportFile json(arguments->json);
    json.write(to_text(evaluate(open_model(arguments->model), arguments->model, arguments->request)));
  });
}

}  // namespace sheen
