// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/session/session.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/live_mesh.h"
#include "reconstructor/capture/tracker_links.h"
#include "reconstructor/render/gl/viewer_state.h"
#include "reconstructor/shape/shape_findings.h"

namespace sheen {

/// In a session's folder: the shape that was found in its images.
inline constexpr const char* kShapeFile = "shape.ply";

/// The shape that stands in a session's folder; null where there is none. Throws FileError.
std::shared_ptr<const Mesh> shape_of_session(const std::filesystem::path& session_folder);

/// The first shape that the images of a session show, five or more of them; meanwhile what comes is received, journaled
/// and acknowledged. On threads of its own.
class FirstShape {
 public:
  /// Session and links must outlive it; nothing else uses them until it is over. `once`: no other source follows one
  /// that ends. `rough`: `ShapeOptions::from`, or null.
  FirstShape(Session& session, TrackerLinks& links, std::filesystem::path session_folder, int hold_out_every, bool once,
             std::shared_ptr<const Mesh> rough, ArrivalObserver observer);

  /// It is there, or none will come.
  bool over() const { return over_; }
  /// How far it is, for people.
  WorkInHand work() const;
  /// Ends the wait. Null where there was none. Throws what went wrong.
  std::shared_ptr<const Mesh> take();

 private:
  void receive(const std::stop_token& stop);
  void find(const std::stop_token& stop);
  std::shared_ptr<const Mesh> try_with(const CaptureSet& captures, const std::stop_token& stop);
  void say(std::string what, double fraction, std::string why = {});

  Session& session_;
  TrackerLinks& links_;
  const std::filesystem::path folder_;
  const int hold_out_every_;
  const bool once_;
  const std::shared_ptr<const Mesh> rough_;
  ArrivalObserver observer_;
  std::atomic<std::uint64_t> stored_{0};
  std::atomic<bool> ended_{false}, over_{false};
  mutable std::mutex mutex_;
  WorkInHand work_;
  std::shared_ptr<const Mesh> found_;
  std::exception_ptr failure_;
  std::jthread receiving_, finding_;
};

/// Each finding: {"kind", "sentence", "images"}.
nlohmann::json findings_report(const std::vector<ShapeFinding>& findings);

/// Finds the shape anew in the images so far, and always goes over to it: it is made of more. `over`: no more captures
/// come, so it takes its time. It stands in the session's folder. A look tells {"triangles", "seen", "findings"}.
/// `on_finding`: told of what keeps it from being better; of each kind once while images come, of all at the end.
/// `rough`: `ShapeOptions::from`, or null.
LookAtMesh shape_look(std::filesystem::path session_folder, std::shared_ptr<const Mesh> rough,
                      std::function<bool()> over, std::function<void(const std::string&)> on_finding);

}  // namespace sheen
