// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_refinement.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "common/geometry/mesh_io.h"
#include "reconstructor/capture/background_threads.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/capture_storing.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/refinement/mesh_findings.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kPoll{100};
constexpr std::size_t kFewestImages = 8;  ///< of fewer, those that judge say little

struct Stopped {};
struct Overtaken {};  ///< all captures have come, many more than are looked at

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

/// Whole or not at all: a start after kill -9 reads it.
void save_refined(const RefinedMesh& refined, const std::filesystem::path& folder) {
  const std::filesystem::path part = folder / (std::string("part_of_") + kRefinedMeshFile);
  const VertexValues values[] = {{"moved", refined.moved}, {"uncertainty", refined.uncertainty}};
  save_ply(refined.mesh, part, values);
  std::filesystem::rename(part, folder / kRefinedMeshFile);
}

}  // namespace

LiveRefinement::LiveRefinement(CaptureLoop& loop, std::filesystem::path session_folder,
                               std::shared_ptr<const Mesh> given, std::shared_ptr<const Mesh> present,
                               LiveRefinementOptions options)
    : loop_(loop),
      folder_(std::move(session_folder)),
      given_(std::move(given)),
      present_(std::move(present)),
      options_(std::move(options)),
      looks_(std::make_unique<nlohmann::json>(nlohmann::json::array())) {}

LiveRefinement::~LiveRefinement() = default;

void LiveRefinement::start() {
  // Whatever goes wrong here, the capture ends with the mesh that it has.
  const auto give_up = [this](const std::exception_ptr& error) {
    loop_.tell(std::nullopt);
    loop_.no_other_mesh_follows();
    log_error("mesh", "it is not refined any more: " + words_of(error));
  };
  thread_ = guarded_thread([this](const std::stop_token& stop) { run(stop); }, give_up);
}

nlohmann::json LiveRefinement::report() const {
  const std::lock_guard lock(mutex_);
  return *looks_;
}

void LiveRefinement::run(const std::stop_token& stop) {
  try {
    BackgroundThreads().run([&] { look_until_over(stop); });
  } catch (const Stopped&) {
  }
  loop_.tell(std::nullopt);
  loop_.no_other_mesh_follows();
}

void LiveRefinement::look_until_over(const std::stop_token& stop) {
  std::uint64_t looked_at = 0, next = options_.first;
  for (bool over = false; !over;) {
    const LoopStatus status = wait_for(next, stop);
    over = status.no_more_captures;
    if (over && !many_more(status.journaled, looked_at)) return;
    try {
      if (const auto mesh = look(status.journaled, stop)) loop_.go_over_to(mesh);
      looked_at = status.journaled;
    } catch (const Overtaken&) {
    }
    loop_.tell(std::nullopt);
    next = static_cast<std::uint64_t>(std::ceil(options_.growth * static_cast<double>(status.journaled)));
  }
}

bool LiveRefinement::many_more(std::uint64_t captures, std::uint64_t looked_at) const {
  return static_cast<double>(captures) >= options_.growth_at_end * static_cast<double>(looked_at);
}

/// Until there are so many captures, or no more come.
LoopStatus LiveRefinement::wait_for(std::uint64_t captures, const std::stop_token& stop) const {
  for (;; std::this_thread::sleep_for(kPoll)) {
    if (stop.stop_requested() || loop_.finished()) throw Stopped();
    LoopStatus status = loop_.status();
    if (status.journaled >= captures || status.no_more_captures) return status;
  }
}

StepsDone LiveRefinement::steps_of(std::uint64_t captures, const std::stop_token& stop) {
  return [this, captures, stop](std::size_t done, std::size_t steps) {
    if (stop.stop_requested() || loop_.finished()) throw Stopped();
    loop_.tell(MeshLook{captures, done, steps});
    const LoopStatus status = loop_.status();
    if (status.no_more_captures && many_more(status.journaled, captures)) throw Overtaken();
  };
}

/// The mesh to go over to; null where the model has the best one.
std::shared_ptr<const Mesh> LiveRefinement::look(std::uint64_t so_many, const std::stop_token& stop) {
  const auto begun = Clock::now();
  const CaptureSet captures = patiently(stop, [&] { return open_capture_set(folder_); });
  const RefinementImages images = training_images(captures, options_.hold_out_every);
  if (images.cameras.size() < kFewestImages) return nullptr;
  const StepsDone progress = steps_of(so_many, stop);
  const JudgedMesh judged = refine_and_judge(*given_, images, progress);
  const Best best = best_of(judged, *given_, *present_, images, progress);
  const std::chrono::duration<double> took = Clock::now() - begun;
  if (loop_.status().no_more_captures && options_.on_finding)
    for (const MeshFinding& finding : findings_of(*given_, judged.refined, images))
      options_.on_finding(finding.sentence);
  {
    const std::lock_guard lock(mutex_);
    looks_->push_back({{"images", images.cameras.size()},
                       {"gain_db", judged.judgement.gain_db},
                       {"standard_error_db", judged.judgement.standard_error},
                       {"seconds", took.count()},
                       {"mesh", name_of(best)}});
  }
  log_info("mesh", "refined against the images so far",
           {{"images", images.cameras.size()}, {"gain_db", judged.judgement.gain_db}, {"mesh", name_of(best)}});
  if (best == Best::kPresent) return nullptr;
  if (best == Best::kRefined) {
    save_refined(judged.refined, folder_);
    present_ = std::make_shared<const Mesh>(judged.refined.mesh);
  } else {
    std::filesystem::remove(folder_ / kRefinedMeshFile);
    present_ = given_;
  }
  return present_;
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
