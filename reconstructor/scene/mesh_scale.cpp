// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/mesh_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr double kInside = 0.8;     ///< of the bounding sphere's radius: corners of a box reach beyond its faces
constexpr double kSmallest_px = 3;  ///< radius in the image: less is nothing that could be captured
constexpr double kMostFit = 0.5;    ///< of the cameras: no doubt about the scale
constexpr double kNearlyAll = 0.9, kHardlyAny = 0.1;

struct Unit {
  double scale;
  const char* name;  ///< of the mesh's numbers, where the cameras' are metres
};
/// The commonest first: with cameras far away several would fit.
constexpr std::array kUnits{Unit{0.001, "millimetres"}, Unit{0.01, "centimetres"}, Unit{0.0254, "inches"},
                            Unit{1000, "kilometres, or the poses millimetres"},
                            Unit{100, "hectometres, or the poses centimetres"}};

std::string length_text(double metres) {
  return metres < 1 ? format("%.3g mm", 1e3 * metres) : format("%.3g m", metres);
}

bool fits(const BoundingSphere& sphere, double scale, const PosedCamera& view) {
  const Eigen::Vector3d centre = view.camera_from_object * Eigen::Vector3d(scale * sphere.centre);
  const double distance = centre.norm(), radius = scale * sphere.radius;
  if (!(distance > kInside * radius) || !(centre.z() > 0)) return false;
  const Camera& c = view.camera;
  const double radius_px = std::sqrt(c.fx * c.fy) * radius / distance;
  const Eigen::Vector2d from_middle(c.fx * centre.x() / centre.z() + c.cx - c.width / 2.0,
                                    c.fy * centre.y() / centre.z() + c.cy - c.height / 2.0);
  return radius_px >= kSmallest_px && from_middle.norm() < std::hypot(c.width, c.height) / 2 + radius_px;
}

double share_that_fits(const BoundingSphere& sphere, double scale, std::span<const PosedCamera> cameras) {
  const auto n =
      std::count_if(cameras.begin(), cameras.end(), [&](const PosedCamera& view) { return fits(sphere, scale, view); });
  return static_cast<double>(n) / static_cast<double>(cameras.size());
}

double median_distance(const BoundingSphere& sphere, std::span<const PosedCamera> cameras) {
  std::vector<double> distances;
  for (const PosedCamera& view : cameras)
    distances.push_back((camera_centre(view.camera_from_object) - sphere.centre).norm());
  return median(distances);
}

}  // namespace

std::string size_text(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  const Eigen::Vector3d sides = box.sizes().cast<double>();
  return sides.maxCoeff() < 1 ? format("%.3g x %.3g x %.3g mm", 1e3 * sides.x(), 1e3 * sides.y(), 1e3 * sides.z())
                              : format("%.3g x %.3g x %.3g m", sides.x(), sides.y(), sides.z());
}

MeshScale judge_scale(const Mesh& mesh, std::span<const PosedCamera> cameras) {
  MeshScale judged;
  if (cameras.empty()) return judged;
  BoundingSphere sphere = bounding_sphere(mesh);
  sphere.centre += mesh.origin;
  judged.fitting = share_that_fits(sphere, 1, cameras);
  if (judged.fitting >= kMostFit) return judged;
  judged.finding = "it is " + size_text(mesh) + ", the cameras stand " + length_text(median_distance(sphere, cameras)) +
                   " from its middle (median), and ";
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) {
    return share_that_fits(sphere, u.scale, cameras) >= kNearlyAll;
  });
  if (judged.fitting <= kHardlyAny && unit != kUnits.end()) {
    judged.remedy = unit->scale;
    judged.finding += std::string("looks like ") + unit->name + ": scale the mesh by " + format("%g", unit->scale);
  } else {
    judged.finding += format("only %.0f %% of them can see it", 100 * judged.fitting) +
                      ": check that mesh and poses are in the same frame and units";
  }
  return judged;
}

std::string ScaleWatch::look(const Capture& capture) {
  constexpr std::size_t kEnough = 5;
  if (judged_ || capture.verdict != FrameVerdict::kKeyframe || !capture.pose.usable()) return {};
  cameras_.push_back({capture.camera, capture.pose.camera_from_object});
  if (cameras_.size() < kEnough) return {};
  judged_ = true;
  return judge_scale(mesh_, cameras_).finding;
}

void check_scale(const std::string& mesh_file, const Mesh& mesh, std::span<const PosedCamera> cameras) {
  const MeshScale judged = judge_scale(mesh, cameras);
  if (judged.remedy) throw FileError(mesh_file, judged.finding);
  if (!judged.finding.empty()) std::fprintf(stderr, "%s: %s\n", mesh_file.c_str(), judged.finding.c_str());
}

}  // namespace sheen
