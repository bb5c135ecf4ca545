// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/pose_refining.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/order_statistics.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/datasets/dataset.h"
#include "common/session/session.h"
#include "reconstructor/commands/mesh_refining.h"

namespace sheen {
namespace {

constexpr int kMostRounds = 4;  // of mesh and poses in turn

JudgedPoses refine_with_bar(const Mesh& mesh, const PosedImages& posed) {
  std::optional<Progress> bar;
  return refine_and_judge_poses(mesh, posed.images, posed.held_out, [&](std::size_t done, std::size_t steps) {
    if (!bar) bar.emplace("refining poses", steps);
    if (stop_requested()) throw Error("stopped while the poses were refined; they were not written");
    bar->update(done);
  });
}

nlohmann::json pose_report(const JudgedPoses& judged) {
  std::vector<double> moves, uncertainties;
  double squares = 0;
  for (const RefinedPose& pose : judged.refined) {
    if (pose.patches == 0) continue;
    moves.push_back(judged.kept_given() ? 0 : pose.moved_px);
    uncertainties.push_back(pose.uncertainty_px);
    squares += moves.back() * moves.back();
  }
  nlohmann::json report{{"images", judged.refined.size()},
                        {"determined", moves.size()},
                        {"left_out",
                         {{"images", judged.judgement.images},
                          {"gain_db", judged.judgement.gain_db},
                          {"standard_error_db", judged.judgement.standard_error},
                          {"kept_given", judged.kept_given()}}}};
  if (moves.empty()) return report;
  report["moved_px_rms"] = std::sqrt(squares / static_cast<double>(moves.size()));
  report["moved_px_largest"] = *std::max_element(moves.begin(), moves.end());
  report["uncertainty_px_median"] = median(uncertainties);
  return report;
}

void print_summary(const nlohmann::json& report) {
  std::printf("poses of %zu of %zu images determined", report["determined"].get<std::size_t>(),
              report["images"].get<std::size_t>());
  if (report.contains("moved_px_rms"))
    std::printf("; moved by %.3g px RMS on the object, %.3g px at most, known to %.2g px",
                report["moved_px_rms"].get<double>(), report["moved_px_largest"].get<double>(),
                report["uncertainty_px_median"].get<double>());
  const nlohmann::json& left_out = report["left_out"];
  std::printf("\n%zu images left out of the fit: %+.2f dB (standard error %.2f)%s\n",
              left_out["images"].get<std::size_t>(), left_out["gain_db"].get<double>(),
              left_out["standard_error_db"].get<double>(),
              left_out["kept_given"].get<bool>() ? "; no gain, so the poses stay as they were" : "");
}

}  // namespace

void check_poses_can_be_refined(const std::filesystem::path& dataset) {
  if (Session::exists(dataset))
    throw FileError(dataset.string(),
                    "is a session, whose poses come from the stage; only those of photographs (transforms.json or "
                    "COLMAP) are refined. `sheen-tracker stage survey` mends the stage");
}

JudgedPoses judge_poses(const Mesh& mesh, const PosedImages& posed, nlohmann::json& report) {
  JudgedPoses judged = refine_with_bar(mesh, posed);
  report = pose_report(judged);
  return judged;
}

JudgedPoses refine_poses_and_print(const Mesh& mesh, const PosedImages& posed, nlohmann::json& report) {
  JudgedPoses judged = judge_poses(mesh, posed, report);
  print_summary(report);
  return judged;
}

JudgedMesh refine_in_turn(const Mesh& mesh, PosedImages& posed, nlohmann::json& report) {
  auto rounds = nlohmann::json::array();
  for (int round = 0;; ++round) {
    JudgedMesh judged = refine_and_print(mesh, posed.images.some(posed.training), report);
    if (round == kMostRounds) return judged;
    const JudgedPoses poses = refine_poses_and_print(kept_mesh(mesh, judged).mesh, posed, rounds.emplace_back());
    report["poses"] = rounds;
    if (poses.kept_given()) return judged;
    for (std::size_t i = 0; i < poses.refined.size(); ++i)
      posed.images.cameras[i].camera_from_object = poses.refined[i].camera_from_object;
  }
}

void write_poses(const std::filesystem::path& dataset, const std::vector<PosedCamera>& poses,
                 const std::filesystem::path& out) {
  std::vector<DatasetView> views = load_dataset(dataset).views;
  if (views.size() != poses.size()) throw FileError(dataset.string(), "changed while its poses were refined");
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].name = relative_name(views[i].image_path, std::filesystem::absolute(out).parent_path());
    views[i].camera_from_object = poses[i].camera_from_object;
  }
  write_transforms(out, views);
}

}  // namespace sheen
