// SPDX-License-Identifier: Apache-2.0
//
// Measures a mesh of a million triangles under images of 12 megapixels: `deploy/measure large [--json FILE]`.
// The demo's object from 100 places, then windows cut out of such images, which show a small part of it: what they take
// says whether an image costs what it shows.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/simulation/camera_path.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"
#include "tests/bench/goal_rows.h"
#include "tests/bench/lit_object.h"

namespace sheen {
namespace {

constexpr int kTriangles = 1'000'000, kImages = 100, kWindows = 10, kHoldOutEvery = 25;
constexpr int kWindow = 4;  // one in so many pixels of a row

/// The middle of a camera's images.
Camera window_of(Camera camera) {
  const int width = camera.width / kWindow, height = camera.height / kWindow;
  camera.cx -= (camera.width - width) / 2;
  camera.cy -= (camera.height - height) / 2;
  camera.width = width;
  camera.height = height;
  return camera;
}

struct Cost {
  std::vector<double> ms, patches;  ///< of each image
  double median_ms() const { return quantile(ms, 0.5); }
  double median_patches() const { return quantile(patches, 0.5); }
};

/// Photographs the object and ingests what is seen, an image after the other.
class Session {
 public:
  explicit Session(const LitObject& object)
      : object_(object), reconstruction_(object.mesh(), SurfaceLightFieldOptions{}) {}

  Cost ingest(const std::vector<CameraStation>& path, const Camera& camera) {
    Cost cost;
    for (const CameraStation& station : path) {
      Capture capture = object_.photograph(camera, station.camera_from_object, ++taken_);
      if (taken_ % kHoldOutEvery == kHoldOutEvery / 2) capture.purpose = Purpose::kHeldOut;
      const auto start = std::chrono::steady_clock::now();
      const IngestReport report = reconstruction_.ingest(capture);
      const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
      resident_ = std::max(resident_, reconstruction_.resident_growth());
      if (report.status != IngestStatus::kAccepted) continue;
      cost.ms.push_back(time.count());
      cost.patches.push_back(static_cast<double>(report.patches_updated));
    }
    return cost;
  }

  Reconstruction& reconstruction() { return reconstruction_; }
  /// The most by which the process had grown after an image, in bytes; what drawing the next one takes is not in it.
  double resident() const { return resident_; }

 private:
  const LitObject& object_;
  Reconstruction reconstruction_;
  std::uint64_t taken_ = 0;
  double resident_ = 0;
};

std::vector<CameraStation> path_of(int images, std::uint64_t seed, const Camera& camera) {
  return camera_path({.frames = images, .nearest_m = 0.30, .farthest_m = 0.36, .jerk_every = 0, .seed = seed}, camera);
}

void measure(GoalReport& report) {
  const LitObject object(make_test_object("demo"), make_demo_mesh(kTriangles));
  const Camera camera = simulated_camera(4000, 3000), window = window_of(camera);
  Session session(object);
  const std::vector<CameraStation> path = path_of(kImages, 1, camera);
  const auto early = path.begin() + kImages / 2, late = path.end() - kWindows;
  session.ingest({path.begin(), early}, camera);
  const Cost middle = session.ingest({early, early + kWindows}, camera);
  session.ingest({early + kWindows, late}, camera);
  const Cost whole = session.ingest({late, path.end()}, camera);
  Reconstruction& reconstruction = session.reconstruction();
  const MemoryAccount memory = reconstruction.memory();
  report.add(at_most(8, {}, "growth of resident memory, 100 images", session.resident() / 1e9, "GB",
                     {{"triangles", object.mesh().triangles.size()},
                      {"model_gb", memory.model / 1e9},
                      {"snapshot_gb", memory.snapshots / 2e9},
                      {"ray_scene_gb", memory.ray_scene / 1e9},
                      {"image_gb", memory.ingest / 1e9}}));
  report.add(
      {.name = "an image, the last of 100",
       .value = whole.median_ms(),
       .unit = "ms",
       .compared_with = {{"patches_shown", whole.median_patches()}, {"after_half_of_them_ms", middle.median_ms()}}});
  const Cost windows = session.ingest(path_of(kWindows, 2, camera), window);
  const double shown = windows.median_patches() / whole.median_patches();
  report.add(at_most(1.5, {}, "an image that shows a part: its time over that part of a whole one's",
                     windows.median_ms() / whole.median_ms() / shown, "ratio",
                     {{"ms", windows.median_ms()}, {"part", shown}}));
  reconstruction.finish();
  const Reconstruction::Judgement judged = reconstruction.judge();
  report.add({.name = "held-out PSNR",
              .value = judged.model.psnr_db,
              .unit = "dB",
              .compared_with = {{"constant_colour_db", judged.constant.psnr_db}, {"ssim", judged.model.ssim}}});
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures a mesh of a million triangles.", sheen::measure);
}
