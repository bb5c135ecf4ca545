// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of the ingest pipeline on this machine: `deploy/measure pipeline [--json FILE]`.
// The demo's object (12K triangles) seen by a 1024x768 Bayer camera from 320 places, shaded by texture, one light and a
// glossy lobe; the paper's settings: 16x16 surface maps, 32x32 view maps, rank 6 (000 sec. 4.1).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "common/simulation/camera_path.h"
#include "common/simulation/sensor.h"
#include "common/simulation/test_object.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/bench/goal_rows.h"

namespace sheen {
namespace {

constexpr int kImages = 320;

/// The object under one directional light: quick to draw, as textured and as glossy as the path-traced one.
ImageF draw(const TestObject& object, const RayPainter& painter, const Camera& camera, const Rigid3& pose) {
  const Eigen::Vector3f light = Eigen::Vector3f(0.4f, -0.3f, 0.87f).normalized();
  const Eigen::Vector3f eye = camera_centre(pose).cast<float>();
  const std::vector<Hit> hits = painter.cast(camera, pose);
  ImageF image(camera.width, camera.height, 3, 0.1f);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i] || !hits[i].front) continue;
    const auto& [a, b, c] = object.mesh.triangles[hits[i].triangle];
    const float u = hits[i].u, v = hits[i].v;
    const Eigen::Vector3f place =
        (1 - u - v) * object.mesh.vertices[a] + u * object.mesh.vertices[b] + v * object.mesh.vertices[c];
    const Eigen::Vector3f normal =
        ((1 - u - v) * object.normals[a] + u * object.normals[b] + v * object.normals[c]).normalized();
    const Eigen::Vector3f half = (light + (eye - place).normalized()).normalized();
    const Eigen::Vector3f diffuse = object.material(place).albedo;
    const float lit = 0.25f + 0.6f * std::max(0.0f, normal.dot(light));
    const float gloss = 0.4f * std::pow(std::max(0.0f, normal.dot(half)), 60.0f);
    Eigen::Map<Eigen::Vector3f>(image.data() + 3 * i) = lit * diffuse + Eigen::Vector3f::Constant(gloss);
  }
  return through_lens(image, kLensSpotPx);
}

Capture photograph(const TestObject& object, const RayPainter& painter, const Camera& camera, const Rigid3& pose,
                   std::uint64_t number) {
  ImageF mosaic = mosaic_rggb(draw(object, painter, camera, pose));
  add_sensor_noise(mosaic, {}, number);
  Capture capture;
  capture.sequence = number;
  capture.camera = camera;
  capture.image = quantize_rggb(mosaic);
  capture.exposure.locked = true;
  capture.pose.status = PoseStatus::kGiven;
  capture.pose.camera_from_object = pose;
  return capture;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void measure(GoalReport& report) {
  const TestObject object = make_test_object("demo");
  const Camera camera = simulated_camera(1024, 768);
  const RayPainter painter(object.mesh);
  const std::vector<CameraStation> path = camera_path({.frames = kImages, .jerk_every = 0}, camera);
  SurfaceLightFieldOptions options{.surface_map = 16, .hold_out_every = 0};
  options.ring.factor = {.max_rank = 6, .block = 6, .tolerance = 0};
  SurfaceLightField model(std::make_shared<Mesh>(object.mesh), options);
  std::vector<double> ms;
  for (int i = 0; i < kImages; ++i) {
    const Capture capture =
        photograph(object, painter, camera, path[i].camera_from_object, static_cast<std::uint64_t>(i + 1));
    const auto start = std::chrono::steady_clock::now();
    model.ingest(capture);
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  const auto around = [&](int image) { return median({ms.begin() + image - 10, ms.begin() + image + 10}); };
  const double rate = 1e3 / median(ms), early = around(30), late = around(300);
  report.add(at_least(5, {}, "ingest, paper's settings", rate, "images/s", {{"median_ms", median(ms)}}));
  report.add(at_most(1.2, {}, "image 300 over image 30", late / early, "ratio",
                     {{"image_30_ms", early}, {"image_300_ms", late}}));
  report.add(at_most(400, {}, "state a ring", model.bytes_per_ring() / 1e3, "kB"));
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of the ingest pipeline on this machine.", sheen::measure);
}
