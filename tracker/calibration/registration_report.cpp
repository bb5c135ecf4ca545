// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/registration_report.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {
namespace {

using nlohmann::json;

json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

json points_json(const PointRegistration& found) {
  json points = json::array();
  for (const RegisteredPoint& point : found.points)
    points.push_back({{"name", point.name},
                      {"used", point.used},
                      {"stage_m", vector_json(point.stage)},
                      {"residual_mm", vector_json(1e3 * point.residual)},
                      {"residual_px", point.residual_px},
                      {"sigmas", point.sigmas},
                      {"from_surface", point.from_surface}});
  return {{"points", points},
          {"rms_mm", 1e3 * found.rms_m},
          {"noise_mm", 1e3 * found.noise_m},
          {"noise_estimated", found.noise_estimated},
          {"degrees_of_freedom", found.degrees_of_freedom}};
}

json images_json(const ImageRegistration& found) {
  const bool outlines = found.evidence == Evidence::kOutlines;
  const std::string measure = outlines ? "outline_px_median" : "correlation";
  return {{"evidence", to_string(found.evidence)},
          {"images", found.images},
          {measure + "_before", found.before},
          {measure + "_after", found.after},
          {"halves_rotation_deg", vector_json(found.halves.head<3>() / kDegree)},
          {"halves_translation_mm", vector_json(1e3 * found.halves.segment<3>(3))},
          {"halves_sigmas", found.halves_sigmas},
          {"undetermined", found.undetermined}};
}

}  // namespace

std::string registration_text(const Registration& registration) {
  std::ostringstream out;
  if (registration.points) {
    out << "point                 residual mm: x      y      z    px   sigmas\n";
    for (const RegisteredPoint& point : registration.points->points) {
      const Eigen::Vector3d mm = 1e3 * point.residual;
      out << format("%-28s %6.2f %6.2f %6.2f %5.2f %6.1f%s\n", point.name.c_str(), mm.x(), mm.y(), mm.z(),
                    point.residual_px, point.sigmas, point.used ? "" : "  OUTLIER, left out");
    }
    out << format("RMS %.3g mm; noise of a coordinate %.3g mm (%s)\n", 1e3 * registration.points->rms_m,
                  1e3 * registration.points->noise_m,
                  registration.points->noise_estimated ? "from the residuals" : "as the file says");
  }
  if (!registration.undone.empty()) out << "the mesh was in another frame: " << registration.undone << '\n';
  if (registration.images) {
    const ImageRegistration& found = *registration.images;
    if (found.evidence == Evidence::kOutlines)
      out << format("outlines of %zu masks: median distance %.2f px, before %.2f px\n", found.images, found.after,
                    found.before);
    else
      out << format("texture in %zu images: mean correlation %.2f, before %.2f\n", found.images, found.after,
                    found.before);
    out << format("the two halves of the images differ by %.3g mm and %.3g degrees\n",
                  1e3 * found.halves.segment<3>(3).norm(), found.halves.head<3>().norm() / kDegree);
  }
  const Placement& placement = registration.placement;
  const Eigen::AngleAxisd turn(placement.stage_from_mesh.rotation);
  const Eigen::Vector3d middle = 1e3 * placement.centre;
  const Eigen::VectorXd sigma = placement.covariance.diagonal().cwiseSqrt();
  out << format("the mesh's middle stands at (%.2f, %.2f, %.2f) mm +- (%.2g, %.2g, %.2g) mm\n", middle.x(), middle.y(),
                middle.z(), 1e3 * sigma[3], 1e3 * sigma[4], 1e3 * sigma[5]);
  out << format("rotated by %.3f degrees about (%.3f, %.3f, %.3f) +- (%.2g, %.2g, %.2g) degrees about x, y, z\n",
                turn.angle() / kDegree, turn.axis().x(), turn.axis().y(), turn.axis().z(), sigma[0] / kDegree,
                sigma[1] / kDegree, sigma[2] / kDegree);
  out << format("scale %.6g metres per unit of the mesh", placement.stage_from_mesh.scale);
  if (registration.free_scale) out << format(" +- %.2g %%", 100 * sigma[6]);
  out << '\n';
  return out.str();
}

std::string registration_json(const Registration& registration) {
  const Placement& placement = registration.placement;
  const Similarity& place = placement.stage_from_mesh;
  json matrix = json::array();
  for (int row = 0; row < 3; ++row)
    matrix.push_back({place.scale * place.rotation(row, 0), place.scale * place.rotation(row, 1),
                      place.scale * place.rotation(row, 2), place.translation[row]});
  matrix.push_back({0, 0, 0, 1});
  const Eigen::VectorXd sigma = placement.covariance.diagonal().cwiseSqrt();
  json covariance = json::array();
  for (int row = 0; row < 7; ++row) {
    covariance.push_back(json::array());
    for (int column = 0; column < 7; ++column) covariance.back().push_back(placement.covariance(row, column));
  }
  json report{{"stage_from_mesh", matrix},
              {"scale", place.scale},
              {"free_scale", registration.free_scale},
              {"centre_m", vector_json(placement.centre)},
              {"uncertainty",
               {{"rotation_deg", vector_json(sigma.head<3>() / kDegree)},
                {"translation_mm", vector_json(1e3 * sigma.segment<3>(3))},
                {"scale_percent", 100 * sigma[6]}}},
              {"covariance", covariance},
              {"warnings", registration.warnings}};
  if (!registration.undone.empty()) report["frame_corrected"] = registration.undone;
  if (registration.points) report["points"] = points_json(*registration.points);
  if (registration.images) report["images"] = images_json(*registration.images);
  return report.dump(2) + "\n";
}

}  // namespace sheen
