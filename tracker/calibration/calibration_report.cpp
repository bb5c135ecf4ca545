// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/calibration_report.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/format.h"
#include "common/base/json_number.h"
#include "common/camera/camera_file.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr const char* kIntrinsicNames[kIntrinsics] = {"f", "fy_over_fx", "cx", "cy", "", "", "", "", ""};
constexpr const char* kBrownNames[5] = {"k1", "k2", "p1", "p2", "k3"};
constexpr const char* kFisheyeNames[5] = {"k1", "k2", "k3", "k4", ""};
constexpr std::size_t kCornersShown = 10;

const char* name_of(const LensFit& fit, int i) {
  if (i < 4) return kIntrinsicNames[i];
  return fit.lens == LensModel::kFisheye ? kFisheyeNames[i - 4] : kBrownNames[i - 4];
}

json map_json(const ImageMap& map) {
  json rows = json::array();
  for (int row = 0; row < map.rows; ++row) {
    json values = json::array();
    for (int column = 0; column < map.columns; ++column) values.push_back(json_number(map.at(column, row)));
    rows.push_back(std::move(values));
  }
  return {{"centre_px", json_number(map.centre())},
          {"rms_px", json_number(map.rms())},
          {"worst_px", json_number(map.worst())},
          {"worst_at", {json_number(map.worst_pixel().x()), json_number(map.worst_pixel().y())}},
          {"grid", std::move(rows)}};
}

json views_json(const CalibrationStudy& study, const CalibrationTarget& target) {
  json views = json::array();
  for (const CalibratedView& view : study.calibration.views) {
    json rejected = json::array();
    for (const RejectedCorner& corner : view.rejected)
      rejected.push_back({{"corner", target.point_name(corner.point)}, {"error_px", json_number(corner.error_px)}});
    json entry = {{"file", view.name},
                  {"used", view.used},
                  {"corners", view.corners},
                  {"rms_px", json_number(view.rms_px)},
                  {"rms_all_px", json_number(view.rms_all_px)},
                  {"rejected", std::move(rejected)}};
    if (!view.used) entry["reason"] = view.reason;
    views.push_back(std::move(entry));
  }
  return views;
}

json lenses_json(const CalibrationStudy& study) {
  json lenses = json::array();
  for (const LensComparison& lens : study.lenses) {
    json entry = {{"lens", lens.fit->name},
                  {"parameters", lens.fit->parameters()},
                  {"estimates", lens.fit->meaning},
                  {"rms_px", json_number(lens.rms_px)},
                  {"cross_validated_px", json_number(lens.cross_validated_px)},
                  {"folds_in_image", lens.folds},
                  {"chosen", lens.fit == study.calibration.fit}};
    if (!lens.failure.empty()) entry["failure"] = lens.failure;
    lenses.push_back(std::move(entry));
  }
  return lenses;
}

void print_views(std::ostream& out, const Calibration& calibration) {
  out << "image                                corners  used  RMS px\n";
  for (const CalibratedView& view : calibration.views) {
    const std::size_t used = view.used ? static_cast<std::size_t>(view.corners) - view.rejected.size() : 0;
    out << format("%-36s %7d %5zu %7.3f%s%s\n", view.name.c_str(), view.corners, used, view.rms_px,
                  view.used ? "" : "  not used: ", view.reason.c_str());
  }
}

void print_outliers(std::ostream& out, const CalibrationStudy& study) {
  std::size_t shown = 0, all = 0;
  for (const CalibratedView& view : study.calibration.views)
    for (const RejectedCorner& corner : view.rejected)
      if (++all <= kCornersShown) {
        out << format("outlier: %s, point %d, off by %.2f px\n", view.name.c_str(), corner.point, corner.error_px);
        ++shown;
      }
  if (all > shown) out << format("and %zu more outliers (--json lists all)\n", all - shown);
}

void print_lenses(std::ostream& out, const CalibrationStudy& study) {
  out << "lens              numbers  RMS px  on views left out\n";
  for (const LensComparison& lens : study.lenses) {
    const char* mark = lens.fit == study.calibration.fit ? "  <- used" : "";
    if (!lens.failure.empty())
      out << format("%-17s %7d  cannot be estimated\n", lens.fit->name, lens.fit->parameters());
    else
      out << format("%-17s %7d %7.4f  %.4f%s%s\n", lens.fit->name, lens.fit->parameters(), lens.rms_px,
                    lens.cross_validated_px, lens.folds ? "  folds over inside the image" : "", mark);
  }
}

}  // namespace

std::string calibration_text(const CalibrationStudy& study, const ViewAdvice& advice) {
  const Calibration& calibration = study.calibration;
  std::ostringstream out;
  print_views(out, calibration);
  print_outliers(out, study);
  print_lenses(out, study);
  const Camera& camera = calibration.camera;
  out << format("fx %.2f  fy %.2f  cx %.2f  cy %.2f (f uncertain by %.2f px)\n", camera.fx, camera.fy, camera.cx,
                camera.cy, std::sqrt(calibration.covariance(0, 0)));
  out << format("RMS %.4f px of %d corners used, %.4f px of all found\n", calibration.rms_px,
                calibration.corners_used(), calibration.rms_all_px);
  out << format("uncertainty of a pixel: %.3f px in the middle, %.3f RMS, %.3f at worst\n", study.uncertainty.centre(),
                study.uncertainty.rms(), study.uncertainty.worst());
  if (study.halves)
    out << format("two halves of the images differ by %.3f px RMS, %.3f at worst; noise explains %.3f RMS\n",
                  study.halves->difference.rms(), study.halves->difference.worst(), study.halves->expected_rms_px);
  if (study.shape)
    out << format(
        "the target's points, estimated too: %.2f mm out of its plane, %.2f mm along it at most; RMS %.4f px\n",
        1e3 * study.shape->out_of_plane_m, 1e3 * study.shape->in_plane_m, study.shape->rms_px);
  out << format(
      "the target was seen in %.0f %% of the image, rotated %.0f to %.0f degrees about the vertical and %.0f "
      "to %.0f about the horizontal axis\n",
      100 * advice.covered, advice.least_turn_deg, advice.greatest_turn_deg, advice.least_nod_deg,
      advice.greatest_nod_deg);
  for (const std::string& sentence : advice.next) out << "next view: " << sentence << '\n';
  for (const std::string& sentence : warnings(study)) out << "warning: " << sentence << '\n';
  return out.str();
}

std::string calibration_json(const CalibrationStudy& study, const ViewAdvice& advice, const CalibrationTarget& target) {
  const Calibration& calibration = study.calibration;
  const Camera& camera = calibration.camera;
  json parameters = json::array();
  const Intrinsics values = intrinsics_of(camera);
  for (int i = 0; i < kIntrinsics; ++i)
    if (calibration.fit->free[i])
      parameters.push_back({{"name", name_of(*calibration.fit, i)},
                            {"value", values[i]},
                            {"uncertainty", std::sqrt(calibration.covariance(i, i))}});
  json report = {{"camera", camera_json(camera)},
                 {"lens", calibration.fit->name},
                 {"parameters", std::move(parameters)},
                 {"rms_px", calibration.rms_px},
                 {"rms_all_px", json_number(calibration.rms_all_px)},
                 {"noise_px", calibration.noise_px},
                 {"corners_used", calibration.corners_used()},
                 {"views", views_json(study, target)},
                 {"lenses", lenses_json(study)},
                 {"uncertainty", map_json(study.uncertainty)},
                 {"halves", nullptr},
                 {"target_shape", nullptr},
                 {"coverage", {{"part", advice.covered}, {"uncovered", advice.uncovered}}},
                 {"tilt_deg",
                  {{"turn", {advice.least_turn_deg, advice.greatest_turn_deg}},
                   {"nod", {advice.least_nod_deg, advice.greatest_nod_deg}}}},
                 {"next_views", advice.next},
                 {"warnings", warnings(study)}};
  if (study.halves) {
    report["halves"] = map_json(study.halves->difference);
    report["halves"]["expected_rms_px"] = study.halves->expected_rms_px;
  }
  if (study.shape)
    report["target_shape"] = {{"rms_px", study.shape->rms_px},
                              {"out_of_plane_mm", 1e3 * study.shape->out_of_plane_m},
                              {"in_plane_mm", 1e3 * study.shape->in_plane_m},
                              {"significance", json_number(study.shape->significance)}};
  return report.dump(2) + "\n";
}

}  // namespace sheen
