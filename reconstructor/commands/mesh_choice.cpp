// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/mesh_choice.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/datasets/applied_transform.h"
#include "common/registration/frame_mistakes.h"
#include "common/registration/placement_check.h"
#include "common/session/session.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/commands/mesh_refining.h"
#include "reconstructor/commands/pose_refining.h"
#include "reconstructor/refinement/mesh_disagreement.h"

namespace sheen {
namespace {

constexpr double kWorthRefining_db = 0.5;       // reflections gain nearly as much on a mesh that is right
constexpr double kFewAgree = 0.02;              // of the vertices looked at: the images do not speak of such a mesh
constexpr std::size_t kFewestImages = 8;        // of fewer, those that judge say little
constexpr std::size_t kMostVertices = 150'000;  // refining takes about 4 kB for each
constexpr std::size_t kSides = 3;               // from which images are taken to find a mistake of frames

/// The same captures, of which none is read once the work is to stop.
CaptureSet until_stopped(CaptureSet captures) {
  captures.read = [read = std::move(captures.read)](std::size_t i) {
    if (stop_requested()) throw Error("stopped before the model was begun; no model was written");
    return read(i);
  };
  return captures;
}

/// The first `count` captures with a pose, from this one on.
std::vector<RegistrationImage> images_from(const CaptureSet& captures, std::size_t first, std::size_t count,
                                           bool& on_stage) {
  std::vector<RegistrationImage> images;
  for (std::size_t i = first; i < captures.size && images.size() < count; ++i) {
    const Capture capture = captures.read(i);
    if (capture.verdict != FrameVerdict::kKeyframe || !capture.pose.usable()) continue;
    images.push_back(registration_image(capture));
    on_stage |= !capture.stage_hash.empty();
  }
  return images;
}

/// Some in turn from each of some sides.
std::vector<RegistrationImage> images_from_sides(const CaptureSet& captures) {
  std::vector<RegistrationImage> all;
  bool unused = false;
  for (std::size_t side = 0; side < kSides; ++side)
    for (RegistrationImage& image : images_from(captures, side * captures.size / kSides, kImagesToCheck, unused))
      all.push_back(std::move(image));
  return all;
}

std::optional<Similarity> applied_similarity(const std::string& dataset) {
  const auto applied = applied_to_poses(dataset);
  if (!applied) return std::nullopt;
  const double scale = applied->block<3, 1>(0, 0).norm();
  return Similarity{scale, applied->topLeftCorner<3, 3>() / scale, applied->topRightCorner<3, 1>()};
}

/// What the first images say against where the mesh stands.
PlacementWarning misplacement(const Mesh& mesh, const CaptureSet& captures, const std::string& dataset) {
  PlacementFacts facts{.on_stage = false, .applied = applied_similarity(dataset), .more = [&captures] {
                         return images_from_sides(captures);
                       }};
  const std::vector<RegistrationImage> first = images_from(captures, 0, kImagesToCheck, facts.on_stage);
  return first.size() < kImagesToCheck ? PlacementWarning{} : placement_warning(mesh, first, facts);
}

MeshDisagreement disagreement(const Mesh& mesh, const RefinementImages& images, nlohmann::json& report) {
  std::optional<Progress> bar;
  const MeshDisagreement found = measure_disagreement(mesh, images, [&](std::size_t done, std::size_t steps) {
    if (!bar) bar.emplace("comparing", steps);
    bar->update(done);
  });
  report["disagreement"] = {{"off_px", found.off_px},
                            {"gain_db", found.gain_db},
                            {"vertices", found.looked_at},
                            {"seen", found.seen},
                            {"observed", found.observed}};
  return found;
}

bool hardly_agree(const MeshDisagreement& found) {
  return static_cast<double>(found.observed) < kFewAgree * static_cast<double>(found.looked_at);
}

/// What the images, which hardly agree about the mesh anywhere, say against it as a whole.
std::string doubt_about(const ChosenMesh& chosen, const MeshDisagreement& found, const std::string& name,
                        const std::string& dataset) {
  const std::vector<RegistrationImage> images = images_from_sides(chosen.captures);
  if (const auto mistake = find_frame_mistake(chosen.mesh, images, applied_similarity(dataset))) {
    std::string doubt = "the images do not agree with where it stands; " + in_words(*mistake);
    std::fprintf(stderr, "%s: %s\n", name.c_str(), doubt.c_str());
    return doubt;
  }
  if (!chosen.doubt.empty()) return chosen.doubt;
  return format("the images agree about only %zu of %zu places of its surface that were looked at", found.observed,
                found.looked_at);
}

/// Whether the images disagree with the mesh by so much that it is refined; says so, and where it is not.
bool is_to_be_refined(const ChosenMesh& chosen, const MeshDisagreement& found, const std::string& name,
                      const std::string& dataset) {
  if (found.gain_db < kWorthRefining_db) return false;
  const char* why_not = Session::exists(dataset)                      ? "a session"
                        : chosen.mesh.vertices.size() > kMostVertices ? "a mesh of so many vertices"
                                                                      : nullptr;
  std::fprintf(stderr, "%s: the images show the surface %.1f pixels (RMS) from where the mesh has it", name.c_str(),
               found.off_px);
  if (why_not)
    std::fprintf(stderr, "; --refine corrects it, which is not done to %s by itself\n", why_not);
  else
    std::fprintf(stderr, ": it is refined (--no-refine keeps it)\n");
  return !why_not;
}

/// That the poses would gain, too, which nobody asked for.
void mention_poses(const Mesh& mesh, const PosedImages& posed, nlohmann::json& report) {
  const JudgedPoses poses = judge_poses(mesh, posed, report["poses_unused"]);
  if (poses.kept_given()) return;
  std::fprintf(stderr,
               "the poses are off as well: images that are left out gain another %.2f dB when they are refined "
               "(--refine poses)\n",
               poses.judgement.gain_db);
}

}  // namespace

Refining refining_of(const std::string& refine, bool no_refine) {
  if (no_refine) return Refining::kNever;
  if (refine.empty()) return Refining::kWhereItGains;
  if (refine == "mesh") return Refining::kMesh;
  if (refine == "poses") return Refining::kMeshAndPoses;
  throw ConfigError("--refine: must be mesh or poses, not \"" + refine + "\"");
}

ChosenMesh choose_mesh(Mesh given, const std::string& name, const std::string& dataset, CaptureSet captures,
                       int hold_out_every, Refining refining, nlohmann::json& report) {
  ChosenMesh chosen{.mesh = std::move(given),
                    .given = {},
                    .captures = until_stopped(std::move(captures)),
                    .poses_refined = false,
                    .doubt = {}};
  const PlacementWarning misplaced = misplacement(chosen.mesh, chosen.captures, dataset);
  chosen.doubt = misplaced.text;
  if (!chosen.doubt.empty()) std::fprintf(stderr, "%s: %s\n", name.c_str(), chosen.doubt.c_str());
  if (refining == Refining::kNever) return chosen;

  const bool with_poses = refining == Refining::kMeshAndPoses;
  if (with_poses) check_poses_can_be_refined(dataset);
  PosedImages posed = posed_images(chosen.captures, hold_out_every);
  const RefinementImages training = posed.images.some(posed.training);
  if (refining == Refining::kWhereItGains) {
    if (misplaced.explained || training.cameras.size() < kFewestImages) return chosen;
    const MeshDisagreement found = disagreement(chosen.mesh, training, report);
    if (hardly_agree(found)) {
      chosen.doubt = doubt_about(chosen, found, name, dataset);
      return chosen;
    }
    if (!is_to_be_refined(chosen, found, name, dataset)) return chosen;
  }
  nlohmann::json& refinement = report["refinement"];
  const JudgedMesh judged =
      with_poses ? refine_in_turn(chosen.mesh, posed, refinement) : refine_and_print(chosen.mesh, training, refinement);
  report_findings(chosen.mesh, name, judged, posed.images.some(posed.training), refinement);
  if (!judged.kept_given()) {
    chosen.given = std::make_shared<const Mesh>(std::move(chosen.mesh));
    chosen.mesh = judged.refined.mesh;
  }
  if (with_poses) {
    chosen.captures = with_poses_of(posed, std::move(chosen.captures));
    chosen.poses_refined = true;
  } else if (refining == Refining::kWhereItGains) {
    mention_poses(chosen.mesh, posed, refinement);
  }
  return chosen;
}

}  // namespace sheen
