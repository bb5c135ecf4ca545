// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of relighting on this machine: `deploy/measure relighting [--json FILE]`.
// The planned spacing of lights: random elements against the tolerance.
// SynthRTI (Dulecha et al. 2020): scenes rendered in 49 lights of a dome, judged in 20 others, 8-bit sRGB, files of at
// most 639 kB. The data are looked for in $SHEEN_DATA; what is not there is not measured.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "common/datasets/light_list.h"
#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/models/irradiance_field/irradiance_field.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"
#include "reconstructor/radiance/radiance_image.h"
#include "tests/bench/goal_rows.h"
#include "tests/bench/relighting_bound.h"
#include "tests/bench/relighting_lamps.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr double kBytes = 639000;
constexpr int kLargeSide = 1024;

std::shared_ptr<const IrradianceFieldSnapshot> in_bytes(IrradianceField& model, double bytes) {
  const auto small = model.snapshot()->compressed({.bytes = bytes}).snapshot;
  return std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(small);
}

struct SceneResult {
  std::string name;
  double psnr_db = 0, bytes = 0, build_s = 0;
};

SceneResult measure_scene(const fs::path& scene, const std::string& name) {
  const auto begin = std::chrono::steady_clock::now();
  const LightList lights = load_light_list(scene / "Dome" / "dirs.lp"),
                  tests = load_light_list(scene / "Test" / "dirs.lp");
  IrradianceField model(std::make_shared<const Mesh>(picture_plane(lights.camera)), {});
  for (std::size_t i = 0; i < lights.views.size(); ++i) model.ingest(read_capture(lights, i));
  const auto small = in_bytes(model, kBytes);
  SceneResult result{.name = name};
  result.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.bytes = static_cast<double>(encode_field(small->scene(), small->field()).size());
  for (std::size_t i = 0; i < tests.views.size(); ++i) {
    const Capture truth = read_capture(tests, i);
    result.psnr_db +=
        squared_error(to_srgb8(small->picture(truth.light)), to_srgb8(level_radiance(truth, 1)), {}).psnr_db() /
        static_cast<double>(tests.views.size());
  }
  const PointKernel& kernel = small->scene().kernel;
  std::printf("  %s: %.2f dB, %.0f bytes, kernel %d, drift %d, depth %.0f, %.1f s\n", name.c_str(), result.psnr_db,
              result.bytes, static_cast<int>(kernel.shape), kernel.drift_degree, static_cast<double>(kernel.depth),
              result.build_s);
  return result;
}

std::vector<SceneResult> measure_scenes(const fs::path& folder, const std::string& prefix) {
  std::vector<fs::path> scenes;
  if (fs::exists(folder))
    for (const auto& entry : fs::directory_iterator(folder)) scenes.push_back(entry.path());
  std::sort(scenes.begin(), scenes.end());
  std::vector<SceneResult> results;
  for (const fs::path& scene : scenes) results.push_back(measure_scene(scene, prefix + scene.filename().string()));
  return results;
}

void report_group(GoalReport& report, const std::vector<SceneResult>& scenes, const std::string& name, double goal,
                  const nlohmann::json& baselines) {
  if (scenes.empty()) return;
  double sum = 0;
  for (const SceneResult& scene : scenes) sum += scene.psnr_db;
  const auto worst = std::min_element(scenes.begin(), scenes.end(),
                                      [](const auto& a, const auto& b) { return a.psnr_db < b.psnr_db; });
  const auto largest =
      std::max_element(scenes.begin(), scenes.end(), [](const auto& a, const auto& b) { return a.bytes < b.bytes; });
  report.add(at_least(goal, {}, name + ", mean of " + std::to_string(scenes.size()) + " scenes",
                      sum / static_cast<double>(scenes.size()), "dB", baselines));
  report.add({name + ", worst scene (" + worst->name + ")", worst->psnr_db, "dB", {}});
  report.add(at_most(kBytes, {}, name + ", largest file", largest->bytes, "bytes"));
}

/// A scene's images, mirrored until they are as large as asked for.
Capture enlarged(const Capture& capture) {
  const ImageF small = level_radiance(capture, 1);
  ImageF large(kLargeSide, kLargeSide, 3);
  const auto mirrored = [](int at, int size) { return at / size % 2 == 0 ? at % size : size - 1 - at % size; };
  for (int y = 0; y < kLargeSide; ++y)
    for (int x = 0; x < kLargeSide; ++x)
      std::copy_n(small.pixel(mirrored(x, small.width()), mirrored(y, small.height())), 3, large.pixel(x, y));
  Capture out = capture;
  const ImageU8 bytes = to_srgb8(large);
  out.mask = ImageU8(kLargeSide, kLargeSide, 1, 255);
  out.camera = capture.camera.scaled(kLargeSide, kLargeSide);
  out.image = {.format = PixelFormat::kRGB8,
               .transfer = Transfer::kSrgb,
               .width = kLargeSide,
               .height = kLargeSide,
               .stride = 3 * std::size_t{kLargeSide},
               .bytes = {bytes.data(), bytes.data() + bytes.size()}};
  return out;
}

/// A light is dragged: the picture in each new light as 8-bit sRGB.
void report_drag(GoalReport& report, const fs::path& scene) {
  const LightList lights = load_light_list(scene / "Dome" / "dirs.lp");
  const Camera large = lights.camera.camera.scaled(kLargeSide, kLargeSide);
  IrradianceField model(std::make_shared<const Mesh>(picture_plane({large, lights.camera.camera_from_object})), {});
  for (std::size_t i = 0; i < lights.views.size(); ++i) model.ingest(enlarged(read_capture(lights, i)));
  const auto small = in_bytes(model, kBytes * kLargeSide * kLargeSide / (320.0 * 320));
  std::vector<double> ms;
  for (int i = 0; i < 40; ++i) {
    const LightState light{.kind = LightKind::kDirectional, .position = {0.01 * i, 0.3 - 0.01 * i, 0.9}};
    const auto begin = std::chrono::steady_clock::now();
    const ImageU8 picture = small->screen_picture(light);
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count() +
                 0.0 * picture.at(0, 0));
  }
  std::nth_element(ms.begin(), ms.begin() + 20, ms.end());
  report.add(at_most(33, {}, "a light is moved, 1024x1024 picture, median", ms[20], "ms",
                     {{"terms of a tile, median", small->figures().median_rank}}));
}

void measure(GoalReport& report) {
  report_bound(report);
  report_lamps(report);
  const char* folder = std::getenv("SHEEN_DATA");
  const fs::path data = fs::path(folder ? folder : "../shared/data") / "relighting", scenes = data / "synthrti_object1";
  report_group(report, measure_scenes(scenes / "Single/Object1", "single "), "SynthRTI object 1, one material", 41.0,
               {{"bilinear18_as_published", 38.67}, {"hsh27_as_published", 35.02}});
  report_group(report, measure_scenes(scenes / "Multi/Object1", "multi "), "SynthRTI object 1, several materials", 34.2,
               {{"bilinear18_as_published", 31.76}, {"hsh27_as_published", 27.88}});
  if (fs::exists(data / "neuralrti_item")) {
    const SceneResult item = measure_scene(data / "neuralrti_item", "item");
    report.add({"NeuralRTI, one relief with shadows", item.psnr_db, "dB", {}});
  }
  if (fs::exists(scenes)) report_drag(report, scenes / "Multi/Object1/material1");
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of relighting.", sheen::measure);
}
