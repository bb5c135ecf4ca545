// SPDX-License-Identifier: Apache-2.0
//
// Measures the goals of finding shapes in images: `deploy/measure shape [--json FILE]`. Photographs: what the model of
// the found mesh scores beside that of the given one. The simulated rig: how far found and true surface are apart, and
// what a capture without a mesh takes. The photographs are looked for in $SHEEN_DATA; what is not there is not
// measured.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh_io.h"
#include "common/simulation/simulated_rig.h"
#include "tests/bench/goal_rows.h"
#include "tests/bench/live_shape.h"
#include "tests/bench/reconstructor_runs.h"
#include "tests/bench/surfaces_apart.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr double kNoWorse_db = 0.2, kHullNoWorse_db = 0.1;

/// Where all that is made stays, for who wants to look.
fs::path measured() {
  return fs::temp_directory_path() / "sheen_measured_shape";
}

/// Closed and of one piece: so there is no cavity, which would be a piece of its own.
void report_soundness(GoalReport& report, const std::string& name, const Mesh& mesh, double share_seen) {
  const MeshDiagnosis found = diagnose(mesh);
  report.add(
      at_most(0, {}, name + ": open edges", double(found.boundary_edges), "", {{"triangles", mesh.triangles.size()}}));
  report.add(at_most(0, {}, name + ": non-manifold edges", double(found.non_manifold_edges), "",
                     {{"inconsistent edges", found.inconsistent_edges}}));
  report.add(at_most(1, {}, name + ": pieces", double(found.components), ""));
  report.add(at_least(0.8, {}, name + ": share of vertices seen", share_seen, ""));
}

/// Photographs with poses, and a mesh that somebody else made of them.
struct PhotographSet {
  std::string name;
  fs::path folder, mesh;
};

struct PhotographFigures {
  ProgramRun cost;
  ImageScores of_shape, of_given;  ///< on the given mesh's pixels
  ImageScores own;                 ///< of the model on the found shape, on its own pixels
  double gain_db() const { return of_shape.psnr_db - of_given.psnr_db; }
};

PhotographFigures measure_photographs(GoalReport& report, const PhotographSet& set, double least_gain_db) {
  const ReconstructorRuns reconstructor(set.folder, measured() / set.name);
  PhotographFigures figures{.cost = reconstructor.find_shape()};
  const fs::path on_shape = reconstructor.model_on(reconstructor.shape()), on_given = reconstructor.model_on(set.mesh);
  figures.of_shape = reconstructor.scores(on_shape, set.mesh);
  figures.of_given = reconstructor.scores(on_given, set.mesh);
  figures.own = reconstructor.scores(on_shape);
  report.add(at_least(least_gain_db, {}, set.name + ": model without a mesh over that of the given one",
                      figures.gain_db(), "dB",
                      {{"without, dB", figures.of_shape.psnr_db},
                       {"without, SSIM", figures.of_shape.ssim},
                       {"given, dB", figures.of_given.psnr_db},
                       {"given, SSIM", figures.of_given.ssim},
                       {"shape, processor s", figures.cost.processor_s},
                       {"shape, wall s", figures.cost.wall_s}}));
  report_soundness(report, set.name, load_mesh(reconstructor.shape()).mesh, reconstructor.share_seen());
  return figures;
}

void report_temple(GoalReport& report, const PhotographFigures& temple) {
  report.add(at_least(26.8, {}, "temple, the given hull's pixels: PSNR", temple.of_shape.psnr_db, "dB"));
  report.add(at_least(0.92, {}, "temple, the given hull's pixels: SSIM", temple.of_shape.ssim, ""));
  report.add(at_least(31.5, {}, "temple, its own pixels: PSNR", temple.own.psnr_db, "dB", {{"SSIM", temple.own.ssim}}));
  double load = 0;
  getloadavg(&load, 1);
  report.add(at_most(60, {}, "temple: time of `shape`", temple.cost.wall_s, "s",
                     {{"processor s", temple.cost.processor_s}, {"processes that wanted to run", load}}));
  report.add(at_most(500, {}, "temple: peak memory of `shape`", 1e-6 * temple.cost.peak_bytes, "MB"));
}

void measure_photograph_sets(GoalReport& report) {
  const char* folder = std::getenv("SHEEN_DATA");
  const fs::path data = folder ? folder : "../shared/data";
  const PhotographSet sets[] = {
      {"temple", data / "temple_middlebury", data / "temple_middlebury/mesh_hull_20k.ply"},
      {"buddha", data / "buddha_alicevision", data / "buddha_alicevision/mesh_poisson_12k.ply"},
      {"cube", data / "cube_desk", data / "cube_desk/mesh_mvs_26k.ply"},
      {"juice", data / "juice_iory", data / "juice_iory/mesh_fusion_28k.ply"},
  };
  int others = 0, better = 0;
  for (const PhotographSet& set : sets) {
    if (!fs::exists(set.mesh)) {
      std::printf("%s: not measured: there is no %s\n", set.name.c_str(), set.mesh.c_str());
      continue;
    }
    const bool temple = set.name == "temple";
    const PhotographFigures figures = measure_photographs(report, set, temple ? -kHullNoWorse_db : -kNoWorse_db);
    if (temple) {
      report_temple(report, figures);
      continue;
    }
    ++others;
    better += figures.gain_db() > 0 ? 1 : 0;
  }
  if (others == 3)
    report.add(at_least(2, {}, "of buddha, cube and juice: better than with the given mesh", better, ""));
  else
    std::printf("how many of buddha, cube and juice are better: not measured, as not all are there\n");
}

/// In both directions.
struct BothWays {
  Apart found_to_true, true_to_found;
};
BothWays both_ways(const Mesh& found, const Mesh& truth, std::span<const PosedCamera> cameras) {
  return {apart(found, truth, cameras), apart(truth, found, cameras)};
}

void report_ways(GoalReport& report, const std::string& name, const BothWays& before, const BothWays& after,
                 double median_mm, double most_mm) {
  const auto add = [&](const char* what, double goal, double value, double before_mm) {
    report.add(at_most(goal, {}, name + ", " + what, value, "mm", {{"before refine, mm", before_mm}}));
  };
  add("found to true, median", median_mm, after.found_to_true.median_mm, before.found_to_true.median_mm);
  add("found to true, 90 %", most_mm, after.found_to_true.most_mm, before.found_to_true.most_mm);
  add("true to found, median", median_mm, after.true_to_found.median_mm, before.true_to_found.median_mm);
  add("true to found, 90 %", most_mm, after.true_to_found.most_mm, before.true_to_found.most_mm);
}

/// The rig's data set without its masks: as a camera sends images.
fs::path without_masks(const fs::path& rig, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  fs::create_directory_symlink(rig / "images", folder / "images");
  fs::copy(rig / "stage.json", folder);
  nlohmann::json transforms = nlohmann::json::parse(std::ifstream(rig / "transforms.json"));
  for (nlohmann::json& frame : transforms.at("frames")) frame.erase("mask_path");
  std::ofstream(folder / "transforms.json") << transforms;
  return folder;
}

void measure_rig(GoalReport& report) {
  SimulationOptions options;  // the glossy teapot
  options.frames = 64;
  options.width = 512;
  options.height = 384;
  const RigRecording rig = cached_recording(options, measured() / "rig").recording;
  const Mesh truth = load_mesh(rig.mesh_file()).mesh;
  std::vector<PosedCamera> cameras;
  for (const RigFrame& frame : rig.frames) cameras.push_back({rig.camera, frame.camera_from_object});
  for (const bool masks : {true, false}) {
    const std::string name = masks ? "teapot, exact masks" : "teapot, stage sheet only";
    const ReconstructorRuns reconstructor(
        masks ? rig.folder : without_masks(rig.folder, measured() / "rig_without_masks"),
        measured() / (masks ? "teapot" : "teapot_without_masks"));
    reconstructor.find_shape();
    reconstructor.refine_shape();
    const Mesh found = load_mesh(reconstructor.shape()).mesh, refined = load_mesh(reconstructor.refined_shape()).mesh;
    report_ways(report, name, both_ways(found, truth, cameras), both_ways(refined, truth, cameras), masks ? 0.20 : 0.40,
                masks ? 1.0 : 1.5);
    report_soundness(report, name + ", refined", refined, reconstructor.share_seen());
  }
}

void measure(GoalReport& report) {
  measure_photograph_sets(report);  // first: a program's peak of memory is not told apart from that of its caller
  measure_rig(report);
  measure_live_shape(report, measured());
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures the goals of finding shapes in images.", sheen::measure);
}
