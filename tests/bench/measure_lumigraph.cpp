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
#include "common/base/order_statistics.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/image/image_metrics.h"
#include "common/simulation/light_rig.h"
#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/studies/depth_merging.h"
#include "reconstructor/studies/still_life.h"
#include "tests/bench/goal_rows.h"

namespace sheen {
namespace {

using Model = std::shared_ptr<const IntrinsicLumigraphSnapshot>;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// `seconds`: from images to the model.
Model build(const std::vector<Capture>& captures, const Mesh& mesh, double& seconds) {
  const auto begin = std::chrono::steady_clock::now();
  IntrinsicLumigraph model(std::make_shared<const Mesh>(mesh), {});
  for (const Capture& capture : captures) model.ingest(capture);
  auto snapshot = std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(model.snapshot());
  seconds = seconds_since(begin);
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
    const SimulatedPicture truth = rig.picture(from, light);
    const ImageU8 expected = to_srgb8(truth.radiance), picture = to_srgb8(painter.paint(from, light));
    const LinearPicture linear_parts = interpolated_truth(rig, from, static_cast<double>(m) + 0.5);
    const ImageU8 linear = to_srgb8(linear_parts.radiance);
    const double db = squared_error(picture, expected, {}).psnr_db();
    result.psnr_db += db;
    result.worst_db = std::min(result.worst_db, db);
    result.linear_db += squared_error(linear, expected, {}).psnr_db();
    const ImageU8 arrives = painter.arrives(from, light);
    for (std::size_t i = 0; i < arrives.size(); ++i) {
      result.shadow.add(arrives.data()[i] < 128, truth.shadow.data()[i] != 0);
      result.linear_shadow.add(linear_parts.arrives.data()[i] < 0.5f, truth.shadow.data()[i] != 0);
    }
    if (!out.empty()) save_comparison(out / (figure + "_" + std::to_string(m) + ".png"), picture, expected, linear);
    ++result.pictures;
  }
  result.psnr_db /= result.pictures;
  result.linear_db /= result.pictures;
  return result;
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
  report.add(at_most(50, {}, which + ": a light is dragged, " + size + ", median per picture", median(light_ms), "ms"));
  report.add({which + ": the eye moves between views, " + size + ", median per picture", median(eye_ms), "ms", {}});
}

void report_midway(GoalReport& report, const std::string& name, const Midway& midway, std::optional<double> goal_db,
                   std::optional<double> gain_db, double goal_iou) {
  const nlohmann::json baselines{{"linear interpolation", midway.linear_db}};
  if (goal_db)
    report.add(at_least(*goal_db, {}, name + ", PSNR, mean of " + std::to_string(midway.pictures), midway.psnr_db, "dB",
                        baselines));
  if (gain_db)
    report.add(at_least(*gain_db, {}, name + ", gain over linear interpolation", midway.psnr_db - midway.linear_db,
                        "dB", {{"PSNR", midway.psnr_db}, {"linear interpolation", midway.linear_db}}));
  report.add({name + ", worst picture", midway.worst_db, "dB", {}});
  report.add(at_least(goal_iou, {}, name + ", shadow IoU", midway.shadow.iou(), "",
                      {{"linear interpolation", midway.linear_shadow.iou()}}));
}

/// 001 figure 3: depth of the central view in each light, merged over lights in three ways.
void report_depth(GoalReport& report, const LightRig& rig) {
  const DepthsByLight depths = depths_by_light(rig);
  const double best = depths.least_error(depths.on_planes), all = depths.error(depths.by_all);
  report.add(
      at_most(0.5, {}, "no mesh: depth error over that of the best light", all / best, "",
              {{"eq. 1, variance", depths.error(depths.by_variance) / best},
               {"eq. 2-4, Hessian", depths.error(depths.by_texture) / best},
               {"over that of the best light, found between planes too", all / depths.least_error(depths.refined)},
               {"best light, mm", 1e3 * best}}));
}

/// How well Otsu's masks of the captured images agree with their shadows.
void report_masks(GoalReport& report, const LightRig& rig, const Model& model) {
  Overlap overlap;
  const IntrinsicView& view = *model->data()->views[rig.cameras().size() / 2];
  for (std::size_t l = 0; l < view.lights.size(); ++l) {
    const ImageU8 truth = rig.picture(view.from, rig.lights()[l]).shadow;
    for (std::size_t i = 0; i < truth.size(); ++i) overlap.add(view.arrives[l].data()[i] < 128, truth.data()[i] != 0);
  }
  report.add({"no mesh: shadows of the captured images by Otsu, IoU", overlap.iou(), "", {}});
}

void measure(GoalReport& report) {
  const char* folder = std::getenv("SHEEN_PICTURES");
  const std::filesystem::path out = folder ? folder : "";
  double seconds = 0;
  for (const double gloss : {0.0, 0.3}) {
    const LightRig rig({.lights = 7, .columns = 5, .rows = 5, .width = 320, .height = 240, .gloss = gloss});
    const std::string scene = gloss > 0 ? "glossy" : "matt";
    const std::vector<Capture> captures = rig_captures(rig);
    const Model known = build(captures, rig.scene().mesh, seconds);
    LumigraphPainter painter(known);
    report_midway(report, scene + ", mesh", judge_midway(rig, rig.central_camera(), painter, scene + "_mesh", out),
                  45.0, {}, 0.98);
    report_midway(report, scene + ", mesh, between views",
                  judge_midway(rig, rig.camera_at(2.5, 2.5), painter, scene + "_mesh_between", out), {}, 6.0, 0.98);
    if (gloss == 0) report_depth(report, rig);
    const Model images = build(captures, view_plane(rig.central_camera()), seconds);
    report.add({scene + ", no mesh: images to model, 7 x 5x5 of 320x240", seconds, "s", {}});
    if (gloss == 0) report_masks(report, rig, images);
    LumigraphPainter without(images);
    report_midway(report, scene + ", no mesh", judge_midway(rig, rig.central_camera(), without, scene + "_images", out),
                  {}, 6.0, 0.80);
    report_midway(report, scene + ", no mesh, between views",
                  judge_midway(rig, rig.camera_at(2.5, 2.5), without, scene + "_images_between", out), {}, 6.0, 0.80);
  }
  const LightRig large({.lights = 7, .columns = 2, .rows = 2, .width = 640, .height = 480});
  const Model model = build(rig_captures(large), large.scene().mesh, seconds);
  report.add(at_most(60, {}, "mesh: 7 x 17x17 views of 640x480, from the time of 2x2", seconds / 4 * 17 * 17, "s"));
  report_speed(report, large, model, "mesh");
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of the intrinsic lumigraph.", sheen::measure);
}
