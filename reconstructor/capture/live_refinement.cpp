// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_refinement.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/errors.h"
#include "common/base/log.h"
#include "common/geometry/mesh_io.h"
#include "reconstructor/refinement/mesh_findings.h"
#include "reconstructor/refinement/mesh_judgement.h"

namespace sheen {
namespace {

/// Which mesh predicts the images that were left out best: the one that was just refined, the one that the model has,
/// or the one that was given.
enum class Best { kRefined, kPresent, kGiven };

Best best_of(const JudgedMesh& judged, const Mesh& given, const Mesh& present, const RefinementImages& images,
             const StepsDone& progress) {
  const auto over = [&](const Mesh& before, const Mesh& after) {
    return judge_mesh(before, after, images, judged.split, progress);
  };
  const bool as_given = &present == &given;
  if (!judged.kept_given() && (as_given || over(present, judged.refined.mesh).refined_is_better()))
    return Best::kRefined;
  if (!as_given && !(over(given, present).gain_db > 0)) return Best::kGiven;
  return Best::kPresent;
}

const char* name_of(Best best) {
  switch (best) {
    case Best::kRefined:
      return "refined";
    case Best::kGiven:
      return "given";
    case Best::kPresent:
      break;
  }
  return "as before";
}

void save_refined(const RefinedMesh& refined, const std::filesystem::path& folder) {
  const VertexValues values[] = {{"moved", refined.moved}, {"uncertainty", refined.uncertainty}};
  save_mesh_of_session(folder, kRefinedMeshFile,
                       [&](const std::filesystem::path& file) { save_ply(refined.mesh, file, values); });
}

}  // namespace

LookAtMesh refining_look(std::filesystem::path folder, std::shared_ptr<const Mesh> given,
                         std::shared_ptr<const Mesh> present, std::function<bool()> over,
                         std::function<void(const std::string&)> on_finding) {
  return [=](const RefinementImages& images, const StepsDone& progress,
             nlohmann::json& told) mutable -> std::shared_ptr<const Mesh> {
    const JudgedMesh judged = refine_and_judge(*given, images, progress);
    const Best best = best_of(judged, *given, *present, images, progress);
    if (over())
      for (const MeshFinding& finding : findings_of(*given, judged.refined, images)) on_finding(finding.sentence);
    told = {{"gain_db", judged.judgement.gain_db},
            {"standard_error_db", judged.judgement.standard_error},
            {"mesh", name_of(best)}};
    log_info("mesh", "refined against the images so far",
             {{"images", images.cameras.size()}, {"gain_db", judged.judgement.gain_db}, {"mesh", name_of(best)}});
    if (best == Best::kPresent) return nullptr;
    if (best == Best::kRefined) {
      save_refined(judged.refined, folder);
      present = std::make_shared<const Mesh>(judged.refined.mesh);
    } else {
      std::filesystem::remove(folder / kRefinedMeshFile);
      present = given;
    }
    return present;
  };
}

std::shared_ptr<const Mesh> refined_mesh_of(const std::filesystem::path& session_folder, const Mesh& given) {
  const std::filesystem::path file = session_folder / kRefinedMeshFile;
  if (!std::filesystem::exists(file)) return nullptr;
  auto refined = std::make_shared<const Mesh>(load_mesh_unchanged(file));
  if (refined->triangles != given.triangles)
    throw FileError(file.string(), "has other triangles than the mesh that is given; remove it to begin with that one");
  return refined;
}

}  // namespace sheen
