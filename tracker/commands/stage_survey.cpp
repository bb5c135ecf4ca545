// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/stage_survey.h"

#include <algorithm>
#include <iostream>
#include <memory>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "tracker/calibration/image_set.h"
#include "tracker/calibration/survey_report.h"
#include "tracker/fiducials/corner_refiner.h"
#include "tracker/fiducials/tag_detector.h"
#include "tracker/rig_config.h"

namespace sheen {
namespace {

struct SurveyArguments {
  std::vector<std::filesystem::path> images;
  std::filesystem::path stage, camera, out, json;
  std::string length;
};

/// A camera file, or the camera of a rig.
CameraFile camera_of(const std::filesystem::path& file) {
  if (file.extension() != ".toml") return load_camera(file);
  const RigConfig rig = load_rig_config(file);
  if (rig.cameras.size() > 1)
    throw ConfigError(file.string() + ": has several cameras; give the camera file of the one that took the images");
  if (!rig.cameras.front().camera) throw ConfigError(file.string() + ": has no [camera]");
  return {*rig.cameras.front().camera, 0};
}

std::vector<SurveyImage> find_tags(const ImageSet& images, const Camera& camera) {
  Progress progress("finding tags", images.files.size());
  TagDetector detector;
  std::vector<SurveyImage> found;
  for_each_image(images, [&](std::size_t i, const GreyImage& image) {
    found.push_back({images.names[i], detector.detect(image.grey)});
    refine_corners(image.light, camera, found.back().tags);
    progress.update(i + 1);
  });
  return found;
}

void survey(const SurveyArguments& arguments) {
  ReportFile json(arguments.json);
  if (!arguments.out.empty()) check_writable(arguments.out);
  const EndOnStop give_up("sheen-tracker: stopped; nothing was written");
  const MeasuredLength length = parse_measured_length(arguments.length);
  const CameraFile camera = camera_of(arguments.camera);
  const StageLayout printed = load_stage(arguments.stage);
  const ImageSet files = find_images(arguments.images);
  if (files.size.width != camera.camera.width || files.size.height != camera.camera.height)
    throw ConfigError("the images are " + std::to_string(files.size.width) + "x" + std::to_string(files.size.height) +
                      ", the camera is " + std::to_string(camera.camera.width) + "x" +
                      std::to_string(camera.camera.height) + "; take both at one size");

  const std::vector<SurveyImage> images = find_tags(files, camera.camera);
  const StageSurvey result = survey_stage(camera.camera, printed, images, length);
  const SurveyQuality quality = measure_quality(camera.camera, printed, images, length, result);
  const auto findings = judge_survey(result, printed, camera.focal_uncertainty);
  std::cout << survey_text(result, quality, findings) << std::flush;
  if (json.wanted()) json.write(survey_json(result, quality, findings));
  for (const SurveyFinding& finding : findings)
    if (finding.fault == SurveyFault::kFocalLength) throw Error("no stage is written: " + finding.text);
  if (arguments.out.empty()) return;
  save_stage(result.stage, arguments.out);
  std::cout << arguments.out.string() << ": the stage as it stands. In rig.toml: [stage] file = \""
            << arguments.out.filename().string() << "\"\n";
}

}  // namespace

void add_stage_survey_command(Command& stage) {
  Command command = stage.subcommand("survey", "Finds where the tags truly stand, from images of the stage.");
  const auto arguments = std::make_shared<SurveyArguments>();
  command.option("images", arguments->images, "images of the stage from all sides, or folders of them").required();
  command.option("--stage", arguments->stage, "the layout as it was printed: stage.json").required();
  command.option("--camera", arguments->camera, "what `calibrate` wrote, or a rig.toml").required();
  command
      .option("--length", arguments->length,
              "the distance between the middles of two tags, measured with a ruler: \"tag 3 to tag 7: 200mm\", or "
              "with its standard deviation \"tag 3 to tag 7: 200mm +- 0.1mm\" (0.25 mm where none is given)")
      .required();
  command.option("--out", arguments->out, "the layout as it stands, for the rig's [stage] file");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { survey(*arguments); });
}

}  // namespace sheen
