// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_findings.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/base/angle.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"

namespace sheen {
namespace {

constexpr double kExplained = 0.5;      // of the moves' squares: less is a mesh that is bent, not one that is elsewhere
constexpr double kWorthSaying = 0.004;  // of the mesh's radius: what a similarity must move the surface by
constexpr double kRidge = 1e-3;         // what the surface does not determine (a ball's rotation) is 0
constexpr double kMaskOfObject = 2;     // a mask larger than this, of the silhouette's area, shows more than the object
constexpr double kMargin = 0.03;        // of the silhouette's size: less is an outline that is off, not a part
constexpr double kLeastMargin_px = 3;
constexpr double kFractionOfImages = 0.1;  // in which a part must be missing to be one

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

/// How far a vertex moves along its normal when scale, offset and rotation about `centre` change.
Vector7 lever(const Eigen::Vector3d& from_centre, const Eigen::Vector3d& normal) {
  Vector7 row;
  row << from_centre.dot(normal), normal, from_centre.cross(normal);
  return row;
}

MeshFinding missing_part(const UncoveredRegion& region, const std::string& image, std::size_t in, std::size_t of) {
  return {"missing part",
          "the masks show a part of the object that the mesh has not: in " + std::to_string(in) + " of " +
              std::to_string(of) + " images, most of it in " + image +
              format(", %.0f pixels round (%.0f, %.0f)", region.pixels, region.centre_x, region.centre_y) +
              "; complete the mesh, or mask the part out"};
}

}  // namespace

MeshOffset common_offset(const Mesh& given, const RefinedMesh& refined) {
  constexpr int kReweightings = 5;
  MeshOffset common;
  const std::vector<Eigen::Vector3f> normals = vertex_normals(given);
  std::vector<std::size_t> observed;
  for (std::size_t v = 0; v < refined.observed.size(); ++v)
    if (refined.observed[v]) observed.push_back(v);
  if (observed.size() < 7) return common;
  for (const std::size_t v : observed)
    common.centre += given.vertices[v].cast<double>() / static_cast<double>(observed.size());
  double radius = 0;
  for (const std::size_t v : observed)
    radius = std::max(radius, (given.vertices[v].cast<double>() - common.centre).norm());

  const auto row = [&](std::size_t v) {
    return lever((given.vertices[v].cast<double>() - common.centre) / radius, normals[v].cast<double>());
  };
  Vector7 solution = Vector7::Zero();
  for (int round = 0; round < kReweightings; ++round) {
    std::vector<double> residuals;
    for (const std::size_t v : observed) residuals.push_back(std::abs(refined.moved[v] - row(v).dot(solution)));
    const double spread = median(residuals);
    Matrix7 equations = kRidge * static_cast<double>(observed.size()) * Matrix7::Identity();
    Vector7 right = Vector7::Zero();
    for (const std::size_t v : observed) {
      const double residual = (refined.moved[v] - row(v).dot(solution)) / (2 * spread + 1e-12 * radius);
      const double weight = 1 / (1 + residual * residual);
      equations += weight * row(v) * row(v).transpose();
      right += weight * refined.moved[v] * row(v);
    }
    solution = equations.ldlt().solve(right);
  }
  common.scale = solution[0] / radius;
  common.offset = solution.segment<3>(1);
  common.rotation = solution.tail<3>() / radius;
  double squares = 0, left = 0;
  for (const std::size_t v : observed) {
    squares += std::pow(refined.moved[v], 2);
    left += std::pow(refined.moved[v] - row(v).dot(solution), 2);
  }
  common.explained = squares > 0 ? 1 - left / squares : 0;
  return common;
}

UncoveredRegion uncovered_region(const ImageU8& mask, const ImageU8& silhouette, double margin_px) {
  const cv::Mat object(mask.height(), mask.width(), CV_8U, const_cast<std::uint8_t*>(mask.data()));
  const cv::Mat shown(silhouette.height(), silhouette.width(), CV_8U, const_cast<std::uint8_t*>(silhouette.data()));
  const int shown_pixels = cv::countNonZero(shown);
  if (shown_pixels == 0 || cv::countNonZero(object) > kMaskOfObject * shown_pixels) return {};
  cv::Mat from_shown, labels, statistics, centres;
  cv::distanceTransform(shown == 0, from_shown, cv::DIST_L2, cv::DIST_MASK_5);
  const cv::Mat uncovered = (from_shown > margin_px) & (object != 0);
  const int regions = cv::connectedComponentsWithStats(uncovered, labels, statistics, centres);
  UncoveredRegion largest;
  for (int i = 1; i < regions; ++i) {  // 0 is what is covered
    const double pixels = statistics.at<int>(i, cv::CC_STAT_AREA);
    if (pixels > largest.pixels) largest = {pixels, centres.at<double>(i, 0), centres.at<double>(i, 1)};
  }
  return largest;
}

std::vector<MeshFinding> findings_of(const Mesh& given, const RefinedMesh& refined, const RefinementImages& images) {
  std::vector<MeshFinding> found;
  const MeshOffset common = common_offset(given, refined);
  const double radius = bounding_sphere(given).radius, least = kWorthSaying * radius;
  if (common.explained > kExplained) {
    if (std::abs(common.scale) * radius > least)
      found.push_back(
          {"scale", format("the mesh is %.2f %% too ", 100 * std::abs(1 / (1 + common.scale) - 1)) +
                        (common.scale < 0 ? "large" : "small") +
                        format(": scale it by %.4f, or check the units of mesh and poses", 1 + common.scale)});
    if (common.offset.norm() > least)
      found.push_back({"offset", "the mesh is in the wrong place: move it by " +
                                     format("(%.3g, %.3g, %.3g) mm, or register it again", 1e3 * common.offset.x(),
                                            1e3 * common.offset.y(), 1e3 * common.offset.z())});
    if (common.rotation.norm() * radius > least) {
      const Eigen::Vector3d axis = common.rotation.normalized();
      found.push_back(
          {"rotation", format("the mesh is rotated: rotate it by %.3g degrees", common.rotation.norm() / kDegree) +
                           format(" about (%.2f, %.2f, %.2f), or register it again", axis.x(), axis.y(), axis.z())});
    }
  }

  const RayScene scene(refined.mesh);
  SilhouetteCaster caster;
  UncoveredRegion largest;
  std::string in_image;
  std::size_t masks = 0, uncovered = 0;
  for (std::size_t i = 0; i < images.cameras.size(); ++i) {
    const Capture capture = images.read(i);
    if (capture.mask.empty()) continue;
    ++masks;
    const ImageU8 silhouette = caster.cast(images.cameras[i], refined.mesh, scene);
    double pixels = 0;
    for (std::size_t k = 0; k < silhouette.size(); ++k) pixels += silhouette.data()[k] != 0;
    const double margin = std::max(kLeastMargin_px, kMargin * std::sqrt(pixels));
    const UncoveredRegion region = uncovered_region(capture.mask, silhouette, margin);
    if (region.pixels < margin * margin) continue;
    ++uncovered;
    if (region.pixels <= largest.pixels) continue;
    largest = region;
    in_image = capture.name;
  }
  if (masks > 0 && static_cast<double>(uncovered) > kFractionOfImages * static_cast<double>(masks))
    found.push_back(missing_part(largest, in_image, uncovered, masks));
  return found;
}

}  // namespace sheen
