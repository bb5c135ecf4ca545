// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_shape.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "common/geometry/mesh_io.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/capture_storing.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/shape/shape.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kPoll{50};
constexpr std::chrono::seconds kPause{2};  // without a capture, after which those that are there are tried
constexpr std::uint64_t kFewestCaptures = 5;
constexpr double kGrowth = 1.4;       // of the captures until it is tried again
constexpr double kSeenAtFirst = 0.3;  // of the vertices: less is no shape to begin with

/// Coarsely at first, so that there soon is something to see: a look searches all images so far, and there is another
/// when they are half as many again.
ShapeOptions while_images_come(std::size_t images, const std::shared_ptr<const Mesh>& rough) {
  constexpr double kPixelsPerImage = 2000, kFewest = 20'000, kMost = 50'000, kTrianglesPerPixel = 0.24;
  const double pixels = std::clamp(kPixelsPerImage * static_cast<double>(images), kFewest, kMost);
  return {.triangles = static_cast<std::size_t>(kTrianglesPerPixel * pixels),
          .most_views = 40,
          .object_pixels = pixels,
          .from = rough.get()};
}

/// Not as fine as that of `shape`: somebody waits for it, and for the model to be saved.
ShapeOptions at_the_end(const std::shared_ptr<const Mesh>& rough) {
  return {.most_views = 40, .object_pixels = 120'000, .from = rough.get()};
}

std::shared_ptr<const Mesh> kept(const FoundShape& found, const std::filesystem::path& folder) {
  save_mesh_of_session(folder, kShapeFile, [&](const std::filesystem::path& file) { save_ply(found.mesh, file); });
  log_info("shape", "found in the images so far",
           {{"views", found.views},
            {"triangles", found.mesh.triangles.size()},
            {"seen", share_known_as(ShapeEvidence::kSeen, found.mesh)}});
  return std::make_shared<const Mesh>(found.mesh);
}

}  // namespace

nlohmann::json findings_report(const std::vector<ShapeFinding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const ShapeFinding& finding : findings)
    list.push_back({{"kind", finding.kind}, {"sentence", finding.sentence}, {"images", finding.images}});
  return list;
}

std::shared_ptr<const Mesh> shape_of_session(const std::filesystem::path& session_folder) {
  const std::filesystem::path file = session_folder / kShapeFile;
  return std::filesystem::exists(file) ? std::make_shared<const Mesh>(load_mesh_unchanged(file)) : nullptr;
}

FirstShape::FirstShape(Session& session, TrackerLinks& links, std::filesystem::path session_folder, int hold_out_every,
                       bool once, std::shared_ptr<const Mesh> rough, ArrivalObserver observer)
    : session_(session),
      links_(links),
      folder_(std::move(session_folder)),
      hold_out_every_(hold_out_every),
      once_(once),
      rough_(std::move(rough)),
      observer_(std::move(observer)),
      stored_(session.size()) {
  const auto fail = [this](const std::exception_ptr& error) {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = error;
    over_ = true;
  };
  receiving_ = guarded_thread([this](const std::stop_token& stop) { receive(stop); }, fail);
  finding_ = guarded_thread(
      [this](const std::stop_token& stop) {
        find(stop);
        over_ = true;
      },
      fail);
}

WorkInHand FirstShape::work() const {
  const std::lock_guard lock(mutex_);
  return work_;
}

void FirstShape::say(std::string what, double fraction, std::string why) {
  const std::lock_guard lock(mutex_);
  work_ = {std::move(what), fraction, std::move(why)};
}

std::shared_ptr<const Mesh> FirstShape::take() {
  for (std::jthread* thread : {&receiving_, &finding_}) thread->request_stop();
  for (std::jthread* thread : {&receiving_, &finding_})
    if (thread->joinable()) thread->join();
  if (failure_) std::rethrow_exception(failure_);
  return found_;
}

void FirstShape::receive(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::optional<TrackerLinks::Arrival> arrival = links_.next(kPoll);
    const std::vector<LinkState> states = links_.states();
    observer_.look(states, arrival);
    if (!arrival && joined(states).ended && once_) ended_ = true;
    if (!arrival || arrival->received.live) continue;
    if (store_capture(session_, links_, *arrival, stop)) stored_ = session_.size();
  }
}

void FirstShape::find(const std::stop_token& stop) {
  std::uint64_t next = kFewestCaptures, tried = 0, counted = 0;
  std::string why = "Move the camera round the object.";
  auto came = std::chrono::steady_clock::now();
  while (!stop.stop_requested()) {
    const bool ended = ended_;  // before what it had stored is counted
    const std::uint64_t stored = stored_;
    if (stored != std::exchange(counted, stored)) came = std::chrono::steady_clock::now();
    const bool paused = stored > tried && stored >= kFewestCaptures && std::chrono::steady_clock::now() - came > kPause;
    if (stored < next && !ended && !paused) {
      say("The first images show the shape: " + std::to_string(stored) + " of " + std::to_string(next) + " are there.",
          static_cast<double>(stored) / static_cast<double>(next), why);
      std::this_thread::sleep_for(kPoll);
      continue;
    }
    tried = stored;
    try {
      found_ = try_with(patiently(stop, [&] { return open_capture_set(folder_); }), stop);
      if (found_) return;
      why = "The shape is not clear yet in " + std::to_string(stored) + " images: move on round the object.";
    } catch (const Error& error) {
      if (stop.stop_requested()) return;
      if (ended) throw;
      why = std::string("No shape yet: ") + error.what();
      log_info("shape", std::string("none yet: ") + error.what(), {{"captures", stored}});
    }
    if (ended)
      throw Error("the images show no shape: less than a third of it was seen by images that agree; or give --mesh");
    next = std::max(stored + 2, static_cast<std::uint64_t>(kGrowth * static_cast<double>(stored)));
  }
}

std::shared_ptr<const Mesh> FirstShape::try_with(const CaptureSet& captures, const std::stop_token& stop) {
  const RefinementImages images = training_images(captures, hold_out_every_);
  const FoundShape found =
      find_shape(images, while_images_come(images.cameras.size(), rough_), [&](std::size_t done, std::size_t steps) {
        if (stop.stop_requested()) throw Error("stopped");
        say("The shape is being found in " + std::to_string(images.cameras.size()) + " images.",
            static_cast<double>(done) / static_cast<double>(steps), "Move the camera on round the object.");
      });
  return share_known_as(ShapeEvidence::kSeen, found.mesh) >= kSeenAtFirst ? kept(found, folder_) : nullptr;
}

LookAtMesh shape_look(std::filesystem::path folder, std::shared_ptr<const Mesh> rough, std::function<bool()> over,
                      std::function<void(const std::string&)> on_finding) {
  return
      [folder = std::move(folder), rough = std::move(rough), over = std::move(over), on_finding = std::move(on_finding),
       said = std::set<std::string>()](const RefinementImages& images, const StepsDone& progress,
                                       nlohmann::json& told) mutable -> std::shared_ptr<const Mesh> {
        const bool last = over();
        const FoundShape found =
            find_shape(images, last ? at_the_end(rough) : while_images_come(images.cameras.size(), rough), progress);
        told = {{"triangles", found.mesh.triangles.size()}, {"seen", share_known_as(ShapeEvidence::kSeen, found.mesh)}};
        const std::vector<ShapeFinding> findings = findings_of(found.measures);
        told["findings"] = findings_report(findings);
        for (const ShapeFinding& finding : findings)
          if ((last || !finding.passes_with_more_images) && said.insert(finding.kind).second)
            on_finding(finding.sentence);
        return kept(found, folder);
      };
}

}  // namespace sheen
