// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/evaluation/foretelling.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/evaluation/photographs.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/models/surface_light_field/constant_colour.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/radiance/ring_resampler.h"
#include "reconstructor/report/report.h"

namespace sheen {
namespace {

struct EvaluateArguments {
  std::string model, dataset, truth, json;
  bool baselines = false;
};

void evaluate(const EvaluateArguments& arguments) {
  ReportFile json(arguments.json);
  const std::shared_ptr<const SurfaceLightFieldSnapshot> model = load_model(arguments.model);
  const ModelOrigin origin = load_origin(arguments.model);
  const CaptureSet captures = open_capture_set(arguments.dataset);
  const RayPainter painter(model->mesh());

  // The constant colour is the mean of each sample over the images that the model was built from.
  RingVisibility visibility(model->mesh(), model->rings(), origin.options.visibility);
  ConstantColour mean(model->shared_mesh(), model->shared_rings());
  const auto photographs = std::make_shared<PhotographSet>(model->shared_mesh(), origin.options.visibility);
  RadianceImage image;
  Eigen::Matrix3Xf encoded;
  std::vector<HeldOutView> views;
  std::size_t known_captures = 0;
  {
    Progress progress("evaluating", captures.size);
    for (std::size_t i = 0; i < captures.size; ++i) {
      const Capture capture = captures.read(i);
      const KnownCapture* known = origin.find(capture);
      if (known) ++known_captures;
      if (known && known->status == IngestStatus::kHeldOut) {
        views.push_back(make_held_out_view(capture, known->exposure_gain, painter));
        if (!arguments.truth.empty()) take_truth_from(arguments.truth, views.back());
      } else if (known) {
        const SurfaceView& view =
            visibility.look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
        if (!known->repeated) {
          image.load(capture, view);
          resample(image, view, model->rings(), known->exposure_gain, encoded, origin.options.sampling);
          mean.add(view, encoded);
        }
        if (arguments.baselines) photographs->add(capture, level_radiance(capture, known->exposure_gain), view);
      }
      progress.update(i + 1);
    }
  }
  if (known_captures == 0)
    throw FileError(arguments.dataset, "has none of the images that " + arguments.model +
                                           " was built from; give the data set or session that it was built from");
  if (views.empty())
    throw FileError(arguments.dataset,
                    "has no view that the model never saw; name some in test_filenames, or build with --hold-out");
  const std::shared_ptr<const ModelSnapshot> constant = mean.snapshot(model->exposure());
  const Scores light_field = score(views, *model, painter), constant_scores = score(views, *constant, painter);
  nlohmann::json report = evaluation_report(light_field, constant_scores);
  print_summary(report);
  const Foretelling foretelling = judge_foretelling(views, *model, painter);
  report["foretelling"] = foretelling_report(foretelling);
  report["predicted_error"] = prediction_report(light_field);
  print_predictions(light_field, foretelling);
  if (arguments.baselines) {
    const BaselineScores baselines{
        constant_scores, score(views, *PhotographSet::nearest_photograph(photographs, constant), painter),
        score(views, *PhotographSet::unstructured_lumigraph(photographs, constant), painter)};
    report["baselines"] = baselines_report(baselines);
    print_baselines(light_field, baselines);
  }
  json.write(to_text(report));
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* command = app.add_subcommand("evaluate", "PSNR and SSIM of a saved model on views that it never saw.");
  command->add_option("model", arguments->model, "folder of a saved model")->required();
  command->add_option("dataset", arguments->dataset, "the images it was built from, and the held-out ones")->required();
  command->add_flag("--baselines", arguments->baselines,
                    "score constant colour, nearest photograph and unstructured lumigraph on the same pixels");
  command->add_option("--truth", arguments->truth,
                      "score against NAME.exr of this folder (linear radiance without noise), not against the images");
  command->add_option("--json", arguments->json, "report to write; - for standard output");
  command->callback([arguments] { evaluate(*arguments); });
}

}  // namespace sheen
