// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of the intrinsic lumigraph on this machine: `deploy/measure lumigraph [--json FILE]`.
// The simulated rig (001's capture: several lights, a grid of cameras) gives images and exact truth. Judged are
// pictures in lights halfway between the captured ones, 8-bit sRGB, and where shadow falls in them.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/files.h"
#include "common/image/image_io.h"
#include "common/image/image_metrics.h"
#include "common/simulation/light_rig.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "tests/bench/goal_rows.h"
#include "tests/support/light_rig_captures.h"

namespace sheen {
namespace {

using Model = std::shared_ptr<const IntrinsicLumigraphSnapshot>;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Intersection over union of two masks.
struct Overlap {
  std::size_t both = 0, either = 0;
  void add(bool a, bool b) {
    both += a && b;
    either += a || b;
  }
  double iou() const { return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 1; }
};

Model build(const LightRig& rig, const std::vector<LitPicture>& pictures, std::shared_ptr<const Mesh> mesh,
            double& build_s) {
  IntrinsicLumigraph model(std::move(mesh), {});
  std::uint64_t sequence = 0;
  double seconds = 0;
  for (std::size_t v = 0; v < rig.cameras().size(); ++v)
    for (std::size_t l = 0; l < rig.lights().size(); ++l) {
      const Capture capture = rig_capture(rig.cameras()[v], rig.lights()[l], pictures[sequence].radiance, sequence + 1);
      ++sequence;
      const auto begin = std::chrono::steady_clock::now();
      model.ingest(capture);
      seconds += seconds_since(begin);
    }
  const auto begin = std::chrono::steady_clock::now();
  auto snapshot = std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(model.snapshot());
  build_s = seconds + seconds_since(begin);
  return snapshot;
}

/// Figures of pictures in midway lights; the means over them.
struct Midway {
  double psnr_db = 0, linear_db = 0, worst_db = 1e9;
  Overlap shadow, linear_shadow;
  int pictures = 0;
};

void save_comparison(const std::filesystem::path& file, const ImageU8& ours, const ImageU8& truth,
                     const ImageU8& linear) {
  const int w = ours.width(), h = ours.height();
  ImageU8 sheet(3 * w, 2 * h, 3);
  constexpr int kErrorScale = 4;
  const auto put = [&](const ImageU8& image, int left, int top, bool error) {
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        for (int c = 0; c < 3; ++c)
          sheet.at(left + x, top + y, c) =
              error ? static_cast<std::uint8_t>(
                          std::min(255, kErrorScale * std::abs(int(image.at(x, y, c)) - int(truth.at(x, y, c)))))
                    : image.at(x, y, c);
  };
  put(ours, 0, 0, false);
  put(truth, w, 0, false);
  put(linear, 2 * w, 0, false);
  put(ours, 0, h, true);
  put(linear, 2 * w, h, true);
  make_folder(file.parent_path());
  write_png(file, sheet);
}

Midway judge_midway(const LightRig& rig, const PosedCamera& from, LumigraphPainter& painter, const std::string& figure,
                    const std::filesystem::path& out) {
  Midway result;
  for (std::size_t m = 0; m < rig.midway_lights().size(); ++m) {
    const LightState& light = rig.midway_lights()[m];
    const LitPicture truth = rig.picture(from, light);
    const ImageU8 expected = to_srgb8(truth.radiance), picture = to_srgb8(painter.paint(from, light));
    const ImageU8 linear = to_srgb8(painter.paint_interpolated(from, light));
    const double db = squared_error(picture, expected, {}).psnr_db();
    result.psnr_db += db;
    result.worst_db = std::min(result.worst_db, db);
    result.linear_db += squared_error(linear, expected, {}).psnr_db();
    const ImageU8 arrives = painter.arrives(from, light);
    const ImageU8 linear_arrives = painter.interpolated_arrives(from, light);
    for (std::size_t i = 0; i < arrives.size(); ++i) {
      result.shadow.add(arrives.data()[i] < 128, truth.shadow.data()[i] != 0);
      result.linear_shadow.add(linear_arrives.data()[i] < 128, truth.shadow.data()[i] != 0);
    }
    if (!out.empty()) save_comparison(out / (figure + "_" + std::to_string(m) + ".png"), picture, expected, linear);
    ++result.pictures;
  }
  result.psnr_db /= result.pictures;
  result.linear_db /= result.pictures;
  return result;
}

double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Milliseconds per picture while a light is dragged, and while the eye moves.
void report_speed(GoalReport& report, const LightRig& rig, const Model& model, const std::string& which) {
  LumigraphPainter painter(model);
  std::vector<double> light_ms, eye_ms;
  const Eigen::Vector3d a = rig.lights()[2].position, b = rig.lights()[3].position;
  const auto timed = [&](const PosedCamera& from, double part, std::vector<double>& ms) {
    LightState light = rig.lights()[0];
    light.position = a + part * (b - a);
    const auto begin = std::chrono::steady_clock::now();
    painter.paint(from, light);
    ms.push_back(1e3 * seconds_since(begin));
  };
  const int column = rig.options().columns / 2, row = rig.options().rows / 2;
  painter.paint(rig.central_camera(), rig.lights()[0]);
  for (int i = 0; i < 15; ++i) timed(rig.central_camera(), (i + 0.5) / 15, light_ms);
  for (int i = 0; i < 15; ++i) timed(rig.camera_at(column + i / 20.0, row), 0.5, eye_ms);
  const std::string size = std::to_string(rig.options().width) + "x" + std::to_string(rig.options().height);
  report.add(
      at_most(50, {}, which + ": a light is dragged, " + size + ", median per picture", median_of(light_ms), "ms"));
  report.add({which + ": the eye moves between views, " + size + ", median per picture", median_of(eye_ms), "ms", {}});
}

void report_midway(GoalReport& report, const std::string& name, const Midway& midway, std::optional<double> goal_db,
                   std::optional<double> gain_db, double goal_iou) {
  const nlohmann::json peers{{"linear interpolation", midway.linear_db}};
  if (goal_db)
    report.add(at_least(*goal_db, {}, name + ", PSNR, mean of " + std::to_string(midway.pictures), midway.psnr_db, "dB",
                        peers));
  if (gain_db)
    report.add(at_least(*gain_db, {}, name + ", gain over linear interpolation", midway.psnr_db - midway.linear_db,
                        "dB", {{"PSNR", midway.psnr_db}, {"linear interpolation", midway.linear_db}}));
  report.add({name + ", worst picture", midway.worst_db, "dB", {}});
  report.add(at_least(goal_iou, {}, name + ", shadow IoU", midway.shadow.iou(), "",
                      {{"linear interpolation", midway.linear_shadow.iou()}}));
}

std::vector<LitPicture> capture_all(const LightRig& rig) {
  std::vector<LitPicture> pictures;
  for (const PosedCamera& from : rig.cameras())
    for (const LightState& light : rig.lights()) pictures.push_back(rig.picture(from, light));
  return pictures;
}

void measure(GoalReport& report) {
  const char* folder = std::getenv("SHEEN_PICTURES");
  const std::filesystem::path out = folder ? folder : "";
  double build_s = 0;
  for (const double gloss : {0.0, 0.3}) {
    const LightRig rig({.lights = 7, .columns = 5, .rows = 5, .width = 320, .height = 240, .gloss = gloss});
    const std::string scene = gloss > 0 ? "glossy rig" : "matt rig";
    const std::vector<LitPicture> pictures = capture_all(rig);
    const Model model = build(rig, pictures, std::make_shared<const Mesh>(rig.scene().mesh), build_s);
    LumigraphPainter painter(model);
    report_midway(report, scene + ", mesh known, midway lights",
                  judge_midway(rig, rig.central_camera(), painter, scene + "_mesh", out),
                  gloss > 0 ? std::nullopt : std::optional(45.0), {}, 0.98);
    report_midway(report, scene + ", mesh known, midway lights between views",
                  judge_midway(rig, rig.camera_at(2.5, 2.5), painter, scene + "_mesh_between", out), {}, 6.0, 0.98);
  }
  const LightRig large({.lights = 7, .columns = 2, .rows = 2, .width = 640, .height = 480});
  const Model model = build(large, capture_all(large), std::make_shared<const Mesh>(large.scene().mesh), build_s);
  report.add({"mesh known: decomposing 7 x 2x2 views of 640x480", build_s, "s", {}});
  report_speed(report, large, model, "mesh known");
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of the intrinsic lumigraph.", sheen::measure);
}
