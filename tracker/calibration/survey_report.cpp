// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/survey_report.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/format.h"
#include "common/base/json_number.h"

namespace sheen {
namespace {

using nlohmann::json;

/// Of a tag of `survey.tags`, that stands on the surveyed stage; null otherwise.
json left_out(const StageSurvey& survey, const SurveyQuality& quality, int id) {
  const StageTag* tag = survey.stage.find(id);
  return tag ? json(quality.left_out_px.at(std::size_t(tag - survey.stage.tags.data()))) : json(nullptr);
}

json tags_json(const StageSurvey& survey, const SurveyQuality& quality) {
  json tags = json::array();
  for (const SurveyedTag& tag : survey.tags) {
    json entry = {{"id", tag.id}, {"surveyed", tag.surveyed}, {"images", tag.images}};
    if (!tag.surveyed) {
      entry["reason"] = tag.reason;
    } else {
      entry["rms_px"] = tag.rms_px;
      entry["left_out_px"] = left_out(survey, quality, tag.id);
      entry["shift_mm"] = {1e3 * tag.shift_m.x(), 1e3 * tag.shift_m.y(), 1e3 * tag.shift_m.z()};
      entry["shift_uncertainty_mm"] = 1e3 * tag.shift_uncertainty_m;
      entry["tilt_deg"] = tag.tilt_deg;
      entry["turn_deg"] = tag.turn_deg;
      entry["tilt_uncertainty_deg"] = tag.tilt_uncertainty_deg;
    }
    tags.push_back(std::move(entry));
  }
  return tags;
}

json images_json(const StageSurvey& survey) {
  json images = json::array();
  for (const SurveyedImage& image : survey.images) {
    json entry = {{"file", image.name}, {"used", image.used}, {"tags", image.tags}, {"rms_px", image.rms_px}};
    if (!image.used) entry["reason"] = image.reason;
    images.push_back(std::move(entry));
  }
  return images;
}

void print_images(std::ostream& out, const StageSurvey& survey) {
  out << "image                                tags  RMS px\n";
  for (const SurveyedImage& image : survey.images)
    out << format("%-36s %4d %7.3f%s%s\n", image.name.c_str(), image.tags, image.rms_px,
                  image.used ? "" : "  not used: ", image.reason.c_str());
}

void print_tags(std::ostream& out, const StageSurvey& survey, const SurveyQuality& quality) {
  out << " tag  images  RMS px  left out px  x mm   y mm   z mm    +-    tilt deg\n";
  for (const SurveyedTag& tag : survey.tags) {
    if (!tag.surveyed) {
      out << format("%4d %7d  not surveyed: %s\n", tag.id, tag.images, tag.reason.c_str());
      continue;
    }
    out << format("%4d %7d %7.3f %12.3f %6.2f %6.2f %6.2f %6.3f %7.2f\n", tag.id, tag.images, tag.rms_px,
                  left_out(survey, quality, tag.id).get<double>(), 1e3 * tag.shift_m.x(), 1e3 * tag.shift_m.y(),
                  1e3 * tag.shift_m.z(), 1e3 * tag.shift_uncertainty_m, tag.tilt_deg);
  }
  out << "(x, y, z: from the place on the sheet as it was printed)\n";
}

}  // namespace

std::string survey_text(const StageSurvey& survey, const SurveyQuality& quality,
                        const std::vector<SurveyFinding>& findings) {
  std::ostringstream out;
  print_images(out, survey);
  print_tags(out, survey, quality);
  out << format("RMS %.3f px; corners of a tag under poses from all others: %.3f px\n", survey.rms_px,
                quality.left_out_rms_px);
  out << format("the sheet is %.3f %% of its size (+- %.3f)\n", 100 * survey.scale, 100 * survey.scale_uncertainty);
  out << format("the focal length that fits best is %.3f %% of the one given (+- %.3f)\n", 100 * survey.focal_ratio,
                100 * survey.focal_uncertainty);
  if (quality.halves_m)
    out << format("two halves of the images differ by %.3f mm RMS; noise explains %.3f\n", 1e3 * *quality.halves_m,
                  1e3 * *quality.halves_expected_m);
  out << format("uncertainty on the object, from the tags' places: %.3f px, %.3f mm\n", quality.object_px,
                1e3 * quality.object_m);
  for (const SurveyFinding& finding : findings) out << "found: " << finding.text << '\n';
  return out.str();
}

std::string survey_json(const StageSurvey& survey, const SurveyQuality& quality,
                        const std::vector<SurveyFinding>& findings) {
  json found = json::array();
  for (const SurveyFinding& finding : findings) {
    found.push_back({{"fault", to_string(finding.fault)}, {"text", finding.text}});
    if (finding.tag >= 0) found.back()["tag"] = finding.tag;
  }
  json report = {{"rms_px", survey.rms_px},
                 {"noise_px", survey.noise_px},
                 {"left_out_px", quality.left_out_rms_px},
                 {"scale", survey.scale},
                 {"scale_uncertainty", survey.scale_uncertainty},
                 {"focal_ratio", survey.focal_ratio},
                 {"focal_uncertainty", survey.focal_uncertainty},
                 {"object_uncertainty_px", quality.object_px},
                 {"object_uncertainty_mm", 1e3 * quality.object_m},
                 {"halves", nullptr},
                 {"findings", std::move(found)},
                 {"tags", tags_json(survey, quality)},
                 {"images", images_json(survey)}};
  if (quality.halves_m)
    report["halves"] = {{"rms_mm", 1e3 * *quality.halves_m}, {"expected_rms_mm", 1e3 * *quality.halves_expected_m}};
  return report.dump(2) + "\n";
}

}  // namespace sheen
