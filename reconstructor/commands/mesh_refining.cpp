// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/mesh_refining.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "reconstructor/refinement/mesh_findings.h"

namespace sheen {
namespace {

JudgedMesh refine_with_bar(const Mesh& mesh, const RefinementImages& images) {
  std::optional<Progress> bar;
  return refine_and_judge(mesh, images, [&](std::size_t done, std::size_t steps) {
    if (!bar) bar.emplace("refining", steps);
    if (stop_requested()) throw Error("stopped while the mesh was refined; nothing was written");
    bar->update(done);
  });
}

nlohmann::json refinement_report(const RefinedMesh& refined, std::size_t images) {
  std::vector<double> moves, uncertainties;
  double squares = 0;
  std::size_t observed = 0;
  for (std::size_t v = 0; v < refined.moved.size(); ++v) {
    squares += double(refined.moved[v]) * refined.moved[v];
    moves.push_back(std::abs(refined.moved[v]));
    if (!refined.observed[v]) continue;
    ++observed;
    uncertainties.push_back(refined.uncertainty[v]);
  }
  const double vertices = static_cast<double>(refined.moved.size());
  nlohmann::json report{{"images", images},
                        {"vertices", refined.moved.size()},
                        {"observed", observed},
                        {"moved_mm_rms", 1e3 * std::sqrt(squares / vertices)},
                        {"moved_mm_largest", 1e3 * *std::max_element(moves.begin(), moves.end())},
                        {"passes", nlohmann::json::array()}};
  if (observed > 0) report["uncertainty_mm_median"] = 1e3 * median(uncertainties);
  for (const RefinementPass& pass : refined.passes)
    report["passes"].push_back({{"spacing_px", pass.spacing_px},
                                {"observed", pass.observed},
                                {"moved", pass.moved},
                                {"moved_mm_rms", 1e3 * pass.rms_move},
                                {"agreement_before", pass.agreement}});
  return report;
}

void print_summary(const nlohmann::json& report) {
  std::printf("%zu images; %zu of %zu vertices observed; moved by %.3g mm RMS, %.3g mm at most\n",
              report["images"].get<std::size_t>(), report["observed"].get<std::size_t>(),
              report["vertices"].get<std::size_t>(), report["moved_mm_rms"].get<double>(),
              report["moved_mm_largest"].get<double>());
  if (report.contains("uncertainty_mm_median"))
    std::printf("uncertainty along the normal: %.3g mm (median of the observed vertices)\n",
                report["uncertainty_mm_median"].get<double>());
  const nlohmann::json& left_out = report["left_out"];
  std::printf("%zu images left out of the fit: %+.2f dB (standard error %.2f)%s\n",
              left_out["images"].get<std::size_t>(), left_out["gain_db"].get<double>(),
              left_out["standard_error_db"].get<double>(),
              left_out["kept_given"].get<bool>() ? "; no gain, so the mesh is written as given" : "");
}

}  // namespace

JudgedMesh refine_and_print(const Mesh& mesh, const RefinementImages& images, nlohmann::json& report) {
  JudgedMesh judged = refine_with_bar(mesh, images);
  report = refinement_report(kept_mesh(mesh, judged), images.cameras.size());
  report["left_out"] = {{"images", judged.judgement.images},
                        {"gain_db", judged.judgement.gain_db},
                        {"standard_error_db", judged.judgement.standard_error},
                        {"kept_given", judged.kept_given()}};
  print_summary(report);
  return judged;
}

RefinedMesh kept_mesh(const Mesh& given, const JudgedMesh& judged) {
  RefinedMesh kept = judged.refined;
  if (!judged.kept_given()) return kept;
  kept.mesh = given;
  kept.moved.assign(given.vertices.size(), 0);
  return kept;
}

void report_findings(const Mesh& given, const std::string& name, const JudgedMesh& judged,
                     const RefinementImages& images, nlohmann::json& report) {
  report["findings"] = nlohmann::json::array();
  for (const MeshFinding& finding : findings_of(given, judged.refined, images)) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), finding.sentence.c_str());
    report["findings"].push_back({{"kind", finding.kind}, {"sentence", finding.sentence}});
  }
}

}  // namespace sheen
