// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of refining meshes and poses: `deploy/measure refinement [--json FILE]`. Meshes of simulated
// objects are disturbed by waves of 1 % of their size, poses by some pixels, and refined against images of the right
// ones.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/geometry/mesh_io.h"
#include "common/geometry/ray_scene.h"
#include "common/simulation/simulated_rig.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/refinement/mesh_judgement.h"
#include "reconstructor/refinement/pose_judgement.h"
#include "reconstructor/scene/scene_config.h"
#include "tests/bench/goal_rows.h"
#include "tests/support/poses_off.h"

namespace sheen {
namespace {

constexpr double kDisturbance = 0.01;  // RMS, of the mesh's largest side

double largest_side(const Mesh& mesh) {
  Eigen::Array3f low = mesh.vertices.front(), high = low;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    low = low.min(v.array());
    high = high.max(v.array());
  }
  return (high - low).maxCoeff();
}

/// Waves along the normals, about so many over the mesh.
Mesh waved(const Mesh& mesh, double rms, double count) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const double side = largest_side(mesh);
  std::vector<double> waves;
  double squares = 0;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    const Eigen::Vector3d p = v.cast<double>() / side;
    const Eigen::Array3d phase = 2 * M_PI * count * p.array();
    waves.push_back(std::sin(phase.x() + 1) * std::cos(phase.y()) + 0.5 * std::sin(1.25 * phase.z()));
    squares += waves.back() * waves.back();
  }
  const double scale = rms / std::sqrt(squares / static_cast<double>(waves.size()));
  Mesh disturbed = mesh;
  for (std::size_t v = 0; v < waves.size(); ++v)
    disturbed.vertices[v] += static_cast<float>(scale * waves[v]) * normals[v];
  return disturbed;
}

/// Of a mesh's vertices from a surface, along their normals, metres.
std::vector<double> distances(const Mesh& mesh, const RayScene& surface, double most) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  std::vector<double> distances;
  for (std::size_t v = 0; v < normals.size(); ++v) {
    double nearest = most;
    for (const float sign : {1.0f, -1.0f})
      if (const Hit hit = surface.intersect(Ray{mesh.vertices[v], sign * normals[v]}))
        nearest = std::min(nearest, static_cast<double>(hit.distance));
    distances.push_back(nearest);
  }
  return distances;
}

double rms(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(values.size(), 1)));
}

/// Without masks: as a camera of a rig sends them.
RefinementImages images_of(const CaptureSet& captures, bool masks) {
  RefinementImages images = training_images(captures, default_scene().settings->hold_out_every);
  if (masks) return images;
  images.masked = false;
  images.read = [read = images.read](std::size_t i) {
    Capture capture = read(i);
    capture.mask = {};
    return capture;
  };
  return images;
}

struct Rig {
  CaptureSet captures;
  Mesh mesh;  ///< the right one
};
Rig rig_with(const std::string& object) {
  SimulationOptions options;
  options.object = object;
  options.frames = 130;
  options.width = 512;
  options.height = 384;
  const CachedRecording cached =
      cached_recording(options, std::filesystem::temp_directory_path() / ("sheen_refinement_" + object));
  const std::filesystem::path& folder = cached.recording.folder;
  return {open_capture_set(folder), load_mesh(folder / "mesh.ply").mesh};
}

void measure_mesh(GoalReport& report, const std::string& object, double waves, bool masks) {
  const Rig rig = rig_with(object);
  const RayScene surface(rig.mesh);
  const double by = kDisturbance * largest_side(rig.mesh);
  const Mesh disturbed = waved(rig.mesh, by, waves);
  const JudgedMesh judged = refine_and_judge(disturbed, images_of(rig.captures, masks));
  const Mesh& refined = judged.kept_given() ? disturbed : judged.refined.mesh;
  const std::vector<double> before = distances(disturbed, surface, 5 * by), left = distances(refined, surface, 5 * by);
  std::vector<double> observed, unobserved;
  for (std::size_t v = 0; v < left.size(); ++v) (judged.refined.observed[v] ? observed : unobserved).push_back(left[v]);
  char name[80];
  std::snprintf(name, sizeof name, "%s, %.3g waves over it%s: left", object.c_str(), waves, masks ? "" : ", no masks");
  report.add(at_most(0.25, {}, name, rms(left) / rms(before), "ratio",
                     {{"disturbance, mm", 1e3 * rms(before)},
                      {"left, mm", 1e3 * rms(left)},
                      {"of vertices that images determine, mm", 1e3 * rms(observed)},
                      {"of the others, mm", 1e3 * rms(unobserved)},
                      {"part of the others", double(unobserved.size()) / double(left.size())},
                      {"median, mm", 1e3 * quantile(left, 0.5)},
                      {"95th percentile, mm", 1e3 * quantile(left, 0.95)}}));
}

void measure_poses(GoalReport& report, const std::string& object, double by_px) {
  const Rig rig = rig_with(object);
  const RefinementImages right = images_of(rig.captures, false);
  const RefinementImages off = with_poses_off(right, bounding_sphere(rig.mesh), by_px, 7);
  const JudgedPoses judged = refine_and_judge_poses(rig.mesh, off, {});
  std::vector<Rigid3> before, after;
  double stated = 0;
  for (const PosedCamera& view : off.cameras) before.push_back(view.camera_from_object);
  for (const RefinedPose& pose : judged.refined) {
    after.push_back(pose.camera_from_object);
    stated += pose.uncertainty_px * pose.uncertainty_px / static_cast<double>(judged.refined.size());
  }
  char name[80];
  std::snprintf(name, sizeof name, "%s, poses off by about %.3g px: left", object.c_str(), by_px);
  report.add({.name = name,
              .value = apart_px(rig.mesh, right.cameras, judged.kept_given() ? before : after),
              .unit = "px",
              .compared_with = {{"off before, px", apart_px(rig.mesh, right.cameras, before)},
                                {"off if it is not judged, px", apart_px(rig.mesh, right.cameras, after)},
                                {"stated uncertainty, px RMS", std::sqrt(stated)},
                                {"gain on images left out, dB", judged.judgement.gain_db}}});
}

void measure(GoalReport& report) {
  for (const char* object : {"demo", "bronze"}) {  // matt and glossy
    for (const double waves : {1.3, 2.6})
      for (const bool masks : {true, false}) measure_mesh(report, object, waves, masks);
    for (const double by_px : {0.0, 0.5, 1.0, 3.0}) measure_poses(report, object, by_px);
  }
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of refining meshes and poses.", sheen::measure);
}
